#include "scored_picture.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

namespace equistream {

namespace {

void require_file(const std::filesystem::path& file, const std::string& expected) {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(file, ignored))
        throw InputError(expected_found(file.string(), expected, "no such file"));
}

ByteImage with_three_channels(ByteImage png) {
    if (png.channels() == 3)
        return png;
    ByteImage rgb(png.width(), png.height(), 3);
    for (std::size_t i = 0; i < rgb.samples().size(); ++i)
        rgb.samples()[i] = png.samples()[i / 3];
    return rgb;
}

void read_exr_colour(ScoredPicture& picture, std::optional<double> exposure) {
    Frame frame;
    try {
        frame = read_exr(picture.file, {"colour"});
    } catch (const WorkError& error) {
        throw InputError(error.what());
    }
    const auto colour = frame.planes.find("colour");
    if (colour == frame.planes.end())
        throw InputError(expected_found(picture.file.string(), "colour channels R, G, B", "none"));
    picture.linear = true;
    picture.radiance = std::move(colour->second);
    picture.exposure = exposure.value_or(frame.info.exposure);
    picture.info = std::move(frame.info);
}

}  // namespace

ScoredPicture read_scored_picture(const std::filesystem::path& file, std::optional<double> exposure) {
    require_file(file, "a picture");
    ScoredPicture picture;
    picture.file = file;
    if (file.extension() == ".exr")
        read_exr_colour(picture, exposure);
    else if (file.extension() == ".png")
        picture.rgb = with_three_channels(read_picture(file));
    else
        throw InputError(expected_found(file.string(), "a .png or an .exr", "'" + file.extension().string() + "'"));
    return picture;
}

FloatImage display_values(const ScoredPicture& picture, const DisplayTransform& transform) {
    return picture.linear ? transform.to_display(picture.radiance.view(), picture.exposure)
                          : widen_8bit(picture.rgb.view());
}

ImageView<const std::uint8_t> display_8bit(const ScoredPicture& picture, const DisplayTransform& transform,
                                           ByteImage& made) {
    if (!picture.linear)
        return picture.rgb.view();
    made = quantise_8bit(display_values(picture, transform).view());
    return std::as_const(made).view();
}

FloatImage exposed_linear(const ScoredPicture& picture, const DisplayTransform& transform) {
    if (!picture.linear) {
        FloatImage linear = transform.to_linear(widen_8bit(picture.rgb.view()).view(), 1);
        for (float& value : linear.samples())
            value = std::clamp(value, 0.f, 1.f);
        return linear;
    }
    FloatImage exposed(picture.width(), picture.height(), 3);
    const auto channels = static_cast<std::size_t>(picture.radiance.channels());
    const auto factor = static_cast<float>(picture.exposure);
    const auto in = picture.radiance.samples();
    const auto out = exposed.samples();
    for (std::size_t i = 0; i < out.size(); ++i) {
        const float radiance = in[i / 3 * channels + i % 3];
        out[i] = std::isnan(radiance) ? 0.f : std::clamp(factor * radiance, 0.f, 1.f);
    }
    return exposed;
}

ByteImage read_mask(const std::filesystem::path& file) {
    require_file(file, "a mask of gap pixels");
    const ByteImage png = read_picture(file);
    const auto channels = static_cast<std::size_t>(png.channels());
    ByteImage mask(png.width(), png.height(), 1);
    for (std::size_t i = 0; i < mask.samples().size(); ++i) {
        const auto pixel = png.samples().subspan(i * channels, channels);
        mask.samples()[i] = std::any_of(pixel.begin(), pixel.end(), [](std::uint8_t v) { return v != 0; }) ? 255 : 0;
    }
    return mask;
}

}  // namespace equistream
