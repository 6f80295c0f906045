#include "alpha_mask.h"

#include <plugin/pictures/encoded_image.h>

#include <equistream/error.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

constexpr int mask_size_limit = 8192;

/// Texel that a coordinate falls on, in [0, size).
int texel(float coordinate, int size, Wrap wrap) {
    float x = coordinate;
    if (wrap == Wrap::repeat) {
        x -= std::floor(x);
    } else if (wrap == Wrap::mirror) {
        x -= 2 * std::floor(x * 0.5f);
        x = x > 1 ? 2 - x : x;
    }
    // Written so that NaN lands on texel 0.
    x = x > 0 ? std::min(x, 1.0f) : 0.0f;
    return std::min(static_cast<int>(x * static_cast<float>(size)), size - 1);
}

}  // namespace

bool AlphaMask::covers(glm::vec2 uv) const {
    const int x = texel(uv.x, width, wrap_u);
    const int y = texel(uv.y, height, wrap_v);
    return opaque[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] != 0;
}

bool AlphaMask::cuts() const {
    return std::find(opaque.begin(), opaque.end(), std::uint8_t{0}) != opaque.end();
}

AlphaMask constant_alpha_mask(bool opaque) {
    AlphaMask mask;
    mask.width = 1;
    mask.height = 1;
    mask.opaque.assign(1, opaque ? 255 : 0);
    return mask;
}

AlphaMask decode_alpha_mask(const MaskImage& image) {
    EncodedImage encoded(image.encoded, image.name, image.where);
    if (encoded.width() > mask_size_limit || encoded.height() > mask_size_limit)
        throw InputError(expected_found(image.where, "an image of 1 to 8192 pixels a side",
                                        std::to_string(encoded.width()) + "x" + std::to_string(encoded.height())));
    const int alpha = encoded.alpha_channel();
    if (alpha < 0 && !image.grey_is_alpha)
        return constant_alpha_mask(image.alpha_factor >= image.cutoff);

    const std::vector<std::uint8_t> samples = encoded.read();
    const auto channels = static_cast<std::size_t>(encoded.channels());
    const auto keep = [&](std::size_t channel) {
        AlphaMask mask;
        mask.width = encoded.width();
        mask.height = encoded.height();
        mask.opaque.resize(samples.size() / channels);
        for (std::size_t i = 0; i < mask.opaque.size(); ++i) {
            const float value = static_cast<float>(samples[i * channels + channel]) / 255.0f;
            mask.opaque[i] = value * image.alpha_factor >= image.cutoff ? 255 : 0;
        }
        return mask;
    };
    if (alpha >= 0) {
        AlphaMask mask = keep(static_cast<std::size_t>(alpha));
        if (!image.grey_is_alpha || mask.cuts())
            return mask;
    }
    return keep(0);
}

}  // namespace equistream
