#pragma once
/// From an encoded image to an AlphaMask.
#include "model.h"

#include <span>
#include <string>

namespace equistream {

struct MaskImage {
    std::span<const std::uint8_t> encoded;  ///< what pictures/encoded_image.h opens
    std::string name;                       ///< the file's: its extension may tell the format
    std::string where;                      ///< for errors
    float alpha_factor = 1;
    float cutoff = 0.5f;
    bool grey_is_alpha = false;  ///< where the image has no alpha, or nothing but opaque: the first channel
};

/// Decodes the image and keeps where alpha * `alpha_factor` >= `cutoff`. Images without alpha cover everything that the
/// factor alone covers. InputError names `where` and what the decoder said.
AlphaMask decode_alpha_mask(const MaskImage& image);

/// Covers nothing or everything: an alpha-masked material without a texture.
AlphaMask constant_alpha_mask(bool opaque);

}  // namespace equistream
