#pragma once
/// An alpha mask as a texture that write_glb embeds.
#include <scenes/library/model.h>

namespace equistream {

/// A PNG of grey and alpha, as a reader of the model decodes it back to the same mask.
Texture mask_texture(const AlphaMask& mask, const std::string& name);

}  // namespace equistream
