#include "image_file.h"
#include "png_check.h"

#include <equistream/aov.h>
#include <equistream/bound.h>
#include <equistream/cryptomatte.h>
#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>
#include <equistream/text.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <vector>

namespace equistream {

namespace fs = std::filesystem;

ByteImage read_picture(const fs::path& file) {
    if (!fs::exists(file))
        throw InputError(file.string() + ": no such file");
    OIIO::Filesystem::IOFile whole(file.string(), OIIO::Filesystem::IOProxy::Read);
    if (const auto damage = png_damage(whole))
        throw InputError(expected_found(file.string(), "a whole PNG picture", *damage));
    std::string problem;
    const auto input = open_image_file(file, problem);
    if (!input)
        throw InputError(expected_found(file.string(), "a picture", problem));
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.width > max_image_side ||
        spec.height > max_image_side || std::int64_t{spec.width} * spec.height > max_image_pixels)
        throw InputError(expected_found(file.string(),
                                        "a picture of at most " + std::to_string(max_image_side) + " a side",
                                        size_text(spec.width, spec.height)));
    if (spec.nchannels < 1)
        throw InputError(expected_found(file.string(), "at least one channel", "none"));
    const int channels = spec.nchannels < 3 ? 1 : 3;
    ByteImage picture(spec.width, spec.height, channels);
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, picture.samples().data()))
        throw InputError(expected_found(file.string(), "a whole picture", input->geterror()));
    return picture;
}

void write_picture(const fs::path& file, ImageView<const std::uint8_t> picture) {
    const auto fail = [&](const std::string& why) {
        return WorkError(file.string() + ": could not be written: " + why);
    };
    const auto output = OIIO::ImageOutput::create(file.string());
    if (!output)
        throw fail(OIIO::geterror());
    if (!output->supports("ioproxy"))
        throw fail(expected_found("its extension", "png", file.extension().string()));
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("png:compressionLevel", 4);
    // Coded in memory: a file's own buffers would hide a full disk until it is too late.
    std::vector<unsigned char> coded;
    OIIO::Filesystem::IOVecOutput memory(coded);
    if (!output->set_ioproxy(&memory) || !output->open(file.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::UINT8, picture.data, OIIO::AutoStride, picture.row_stride) ||
        !output->close())
        throw fail(output->geterror());
    write_file_atomically(file, std::string(coded.begin(), coded.end()));
}

namespace {

using Rgb = std::array<double, 3>;

Rgb hsv(double hue_turns, double saturation, double value) {
    const auto channel = [&](double offset) {
        const double k = std::fmod(offset + hue_turns * 6, 6.0);
        return value - value * saturation * std::clamp(std::min(k, 4 - k), 0.0, 1.0);
    };
    return {channel(5), channel(3), channel(1)};
}

void store(std::uint8_t* to, const Rgb& colour) {
    for (std::size_t c = 0; c < 3; ++c)
        to[c] = colour[c] > 0 ? static_cast<std::uint8_t>(std::min(colour[c], 1.0) * 255 + 0.5) : 0;  // NaN: black
}

/// Calls `colour(sample pointer)` for each pixel of a plane.
template <typename T, typename F>
ByteImage map_plane(const Image<T>& plane, F colour) {
    ByteImage picture(plane.width(), plane.height(), 3);
    for (int y = 0; y < plane.height(); ++y)
        for (int x = 0; x < plane.width(); ++x)
            store(picture.pixel(x, y), colour(plane.pixel(x, y)));
    return picture;
}

/// Log of w = B / (r - B), scaled to the frame's own range (its 0.5 % and 99.5 % points, so that one wire does not set
/// the scale). The scale cancels log B, so it is left out: then a head that never moves, B = 0, has a picture too.
ByteImage depth_picture(const FloatImage& depth, double box_radius_m) {
    std::vector<double> logs;
    const auto log_w = [&](float distance_m) {
        return -std::log(std::max<double>(distance_m, 1.01 * box_radius_m) - box_radius_m);
    };
    for (const float distance_m : depth.samples())
        if (std::isfinite(distance_m) && distance_m > 0)
            logs.push_back(log_w(distance_m));
    if (logs.empty())
        return ByteImage(depth.width(), depth.height(), 3);
    const auto quantile = [&](double q) {
        const auto at = logs.begin() + std::lround(q * static_cast<double>(logs.size() - 1));
        std::nth_element(logs.begin(), at, logs.end());
        return *at;
    };
    const double far = quantile(0.005);
    const double near = std::max(quantile(0.995), far + 1e-6);
    return map_plane(depth, [&](const float* distance_m) -> Rgb {
        if (!std::isfinite(*distance_m) || *distance_m <= 0)
            return {0, 0, 0};
        const double nearness = std::clamp((log_w(*distance_m) - far) / (near - far), 0.0, 1.0);
        return hsv(0.68 * (1 - nearness), 0.85, 0.35 + 0.65 * nearness);
    });
}

ByteImage motion_picture(const FloatImage& motion) {
    double longest = 1e-6;
    for (int y = 0; y < motion.height(); ++y)
        for (int x = 0; x < motion.width(); ++x)
            longest = std::max(longest, std::min<double>(std::hypot(motion.pixel(x, y)[0], motion.pixel(x, y)[1]),
                                                         0.02 * motion.width()));
    return map_plane(motion, [&](const float* m) {
        const double turns = std::atan2(m[1], m[0]) / (2 * std::numbers::pi) + 0.5;
        return hsv(turns, 0.8, std::sqrt(std::min(1.0, std::hypot(m[0], m[1]) / longest)));
    });
}

Rgb colour_of_id(std::uint32_t id) {
    if (id == 0)
        return {0, 0, 0};
    const double golden = std::numbers::phi - 1;
    return hsv(std::fmod(id * golden, 1.0), 0.45 + 0.4 * std::fmod(id * 0.37, 1.0),
               0.95 - 0.4 * std::fmod(id * 0.73, 1.0));
}

ByteImage id_picture(const IdImage& ids) {
    return map_plane(ids, [](const std::uint32_t* id) { return colour_of_id(*id); });
}

/// Black is 0. White is the frame's highest number, or 1 where none is higher.
ByteImage grey_picture(const FloatImage& plane) {
    float highest = 1;
    for (const float number : plane.samples())
        highest = std::isfinite(number) ? std::max(highest, number) : highest;
    return map_plane(plane, [highest](const float* number) {
        const double grey = std::clamp(number[0] / highest, 0.0f, 1.0f);
        return Rgb{grey, grey, grey};
    });
}

/// Colours of ids, mixed by how much each covers.
ByteImage cryptomatte_picture(const FloatImage& plane) {
    return map_plane(plane, [](const float* pairs) {
        Rgb mixed{};
        for (int rank = 0; rank < cryptomatte_ranks; ++rank, pairs += 2) {
            const Rgb colour = colour_of_id(std::bit_cast<std::uint32_t>(pairs[0]));
            for (std::size_t c = 0; c < 3; ++c)
                mixed[c] += pairs[1] > 0 && pairs[1] <= 1 ? double(pairs[1]) * colour[c] : 0;
        }
        return mixed;
    });
}

}  // namespace

ByteImage picture_of_plane(const Frame& frame, const std::string& plane, const DisplayTransform& display) {
    if (const auto ids = frame.ids.find(plane); ids != frame.ids.end())
        return id_picture(ids->second);
    const auto found = frame.planes.find(plane);
    if (found == frame.planes.end())
        throw InputError(
            expected_found("frame " + std::to_string(frame.info.index), "a plane '" + plane + "'", "none"));
    const FloatImage& image = found->second;
    if (plane == "depth" || plane == "virtual_depth")
        return depth_picture(image, head_box_radius(frame.info.eye, frame.info.head_radius_m, frame.info.ipd_m));
    if (find_aov(plane) && find_aov(plane)->unit == "pixel")
        return motion_picture(image);
    if (plane == "normal")
        return map_plane(image, [](const float* n) {
            return Rgb{0.5 + 0.5 * n[0], 0.5 + 0.5 * n[1], 0.5 + 0.5 * n[2]};
        });
    if (find_aov(plane) && find_aov(plane)->group == "cryptomatte")
        return cryptomatte_picture(image);
    if (image.channels() == 1)
        return grey_picture(image);
    const bool is_light = find_aov(plane) && find_aov(plane)->unit == "radiance";
    const double exposure = is_light ? frame.info.exposure : 1;
    return quantise_8bit(display.to_display(image.view(), exposure).view());
}

}  // namespace equistream
