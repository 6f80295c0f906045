#include "alpha_mask.h"

#include "pictures/png_check.h"

#include <equistream/error.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

namespace equistream {

namespace {

constexpr int mask_size_limit = 8192;

/// OpenImageIO's name of the format that the first bytes announce.
const char* format_of(std::span<const std::uint8_t> encoded) {
    static constexpr std::uint8_t png[] = {0x89, 'P', 'N', 'G'};
    static constexpr std::uint8_t jpeg[] = {0xff, 0xd8};
    if (encoded.size() >= sizeof png && std::memcmp(encoded.data(), png, sizeof png) == 0)
        return "png";
    if (encoded.size() >= sizeof jpeg && std::memcmp(encoded.data(), jpeg, sizeof jpeg) == 0)
        return "jpeg";
    return nullptr;
}

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

AlphaMask constant_alpha_mask(bool opaque) {
    AlphaMask mask;
    mask.width = 1;
    mask.height = 1;
    mask.opaque.assign(1, opaque ? 255 : 0);
    return mask;
}

AlphaMask decode_alpha_mask(std::span<const std::uint8_t> encoded, float alpha_factor, float cutoff,
                            const std::string& where) {
    const char* format = format_of(encoded);
    if (!format)
        throw InputError(expected_found(where, "a PNG or JPEG image", "other data"));
    if (const auto damage = png_damage(encoded))
        throw InputError(expected_found(where, "a whole PNG image", *damage));
    OIIO::Filesystem::IOMemReader memory(const_cast<std::uint8_t*>(encoded.data()), encoded.size());
    // Straight alpha is asked for: premultiplying would cost time and change nothing in the alpha channel.
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    const std::unique_ptr<OIIO::ImageInput> input = OIIO::ImageInput::create(format);
    if (!input)
        throw InputError(expected_found(where, "an image that OpenImageIO reads", OIIO::geterror()));
    OIIO::ImageSpec spec;
    if (!input->set_ioproxy(&memory) || !input->open(where, spec, config))
        throw InputError(expected_found(where, "a readable image", input->geterror()));
    if (spec.width < 1 || spec.height < 1 || spec.width > mask_size_limit || spec.height > mask_size_limit)
        throw InputError(expected_found(where, "an image of 1 to 8192 pixels a side",
                                        std::to_string(spec.width) + "x" + std::to_string(spec.height)));
    if (spec.alpha_channel < 0)
        return constant_alpha_mask(alpha_factor >= cutoff);

    AlphaMask mask;
    mask.width = spec.width;
    mask.height = spec.height;
    mask.opaque.resize(static_cast<std::size_t>(spec.width) * static_cast<std::size_t>(spec.height));
    const int channel = spec.alpha_channel;
    std::vector<std::uint8_t> pixels(mask.opaque.size() * static_cast<std::size_t>(spec.nchannels));
    if (!input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, pixels.data()))
        throw InputError(expected_found(where, "a readable image", input->geterror()));
    for (std::size_t i = 0; i < mask.opaque.size(); ++i) {
        const std::uint8_t alpha =
            pixels[i * static_cast<std::size_t>(spec.nchannels) + static_cast<std::size_t>(channel)];
        mask.opaque[i] = static_cast<float>(alpha) / 255.0f * alpha_factor >= cutoff ? 255 : 0;
    }
    return mask;
}

}  // namespace equistream
