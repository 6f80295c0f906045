#pragma once
/// An encoded image in memory as OpenImageIO sees it: an ImageInput with all MIP levels, 8-bit RGB.
#include "textures.h"

#include <OpenImageIO/imageio.h>

#include <array>
#include <cstdint>
#include <vector>

namespace equistream::embree_host {

/// What the texture system is given for one image. `texture` is borrowed.
class MipChainSource {
public:
    const Texture* texture = nullptr;
    TextureCoding coding = TextureCoding::colour;
};

/// A level of an image: width * height RGB triplets, top row first.
struct MipLevel {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgb;
};

/// sRGB code value to linear, and code value to [0, 1].
const std::array<float, 256>& decode_table(TextureCoding coding);

/// Levels from full size to 1x1, each half the last (rounded down).
int mip_level_count(int width, int height);

/// One of them, 0 for the full size. Throws InputError if the image cannot be decoded.
MipLevel make_mip_level(const MipChainSource& source, int level);

/// Config attribute that carries a `const MipChainSource*` to the ImageInput below.
inline constexpr const char* mip_source_attribute = "equistream:source";
OIIO::ImageInput* create_mip_chain_input();

}  // namespace equistream::embree_host
