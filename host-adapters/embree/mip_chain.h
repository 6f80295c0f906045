#pragma once
/// An encoded image in memory as OpenImageIO sees it: an ImageInput with all MIP levels, 8-bit RGB.
#include "textures.h"

#include <equistream/image.h>

#include <OpenImageIO/imageio.h>

#include <array>

namespace equistream::embree_host {

/// What the texture system is given for one image. `texture` is borrowed. `is_cut`: materials cut it away by its alpha,
/// so coarser levels are weighted by that. Elsewhere alpha has no meaning.
struct MipChainSource {
    const Texture* texture = nullptr;
    TextureCoding coding = TextureCoding::colour;
    bool is_cut = false;
};

/// sRGB code value to linear, and code value to [0, 1].
const std::array<float, 256>& decode_table(TextureCoding coding);

/// Levels from full size to 1x1, each half the last (rounded down).
int mip_level_count(int width, int height);

/// One of them, 0 for the full size: RGB. Throws InputError if the image cannot be decoded.
ByteImage make_mip_level(const MipChainSource& source, int level);

/// Config attribute that carries a `const MipChainSource*` to the ImageInput below.
inline constexpr const char* mip_source_attribute = "equistream:source";
OIIO::ImageInput* create_mip_chain_input();

}  // namespace equistream::embree_host
