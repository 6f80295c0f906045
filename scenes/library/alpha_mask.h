#pragma once
/// From an encoded image to an AlphaMask.
#include <equistream_scene/model.h>

#include <span>
#include <string>

namespace equistream {

/// Decodes PNG or JPEG from memory and keeps where alpha * `alpha_factor` >= `cutoff`. Images without alpha cover
/// everything that the factor alone covers. InputError names `where` and what the decoder said.
AlphaMask decode_alpha_mask(std::span<const std::uint8_t> encoded, float alpha_factor, float cutoff,
                            const std::string& where);

/// Covers nothing or everything: an alpha-masked material without a texture.
AlphaMask constant_alpha_mask(bool opaque);

}  // namespace equistream
