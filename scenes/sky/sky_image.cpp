#include "sky_image.h"

#include <equistream/error.h>
#include <equistream/rec709.h>
#include <plugin/pictures/image_file.h>

#include <OpenImageIO/imageio.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

namespace equistream {
namespace {

/// Decoders quote names out of damaged files, which are in no encoding.
std::string printable(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) > 126; }, '?');
    return text;
}

std::string size_text(const OIIO::ImageSpec& spec) {
    return std::to_string(spec.width) + "x" + std::to_string(spec.height) + " with " + std::to_string(spec.nchannels) +
           " channels";
}

/// Channels to read: three, or one for grey. OpenImageIO puts R, G and B first wherever they are in the file.
int colour_channels(const OIIO::ImageSpec& spec, const std::string& where) {
    if (spec.nchannels == 1)
        return 1;
    const auto& names = spec.channelnames;
    if (spec.nchannels >= 3 && names[0] == "R" && names[1] == "G" && names[2] == "B")
        return 3;
    std::string found;
    for (const std::string& name : names)
        found += (found.empty() ? "" : ", ") + name;
    throw InputError(expected_found(where, "channels R, G and B, or one alone, in a sky image", printable(found)));
}

void check_header(const OIIO::ImageSpec& spec, const std::string& where) {
    if (!spec.format.is_floating_point())
        throw InputError(expected_found(where, "a sky image of floating-point radiance (.exr, .hdr)",
                                        std::string("pixels of type ") + spec.format.c_str()));
    if (spec.get_string_attribute("textureformat").find("CubeFace") != std::string::npos)
        throw InputError(expected_found(where, "a lat-long sky image", "the faces of a cube"));
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || std::int64_t{spec.width} * spec.height > max_sky_pixels)
        throw InputError(expected_found(where, "a sky image of 1 to " + std::to_string(max_sky_pixels) + " pixels",
                                        size_text(spec)));
    if (spec.x != spec.full_x || spec.y != spec.full_y || spec.width != spec.full_width ||
        spec.height != spec.full_height)
        throw InputError(expected_found(where, "a whole sky image",
                                        "one that has " + std::to_string(spec.width) + "x" +
                                            std::to_string(spec.height) + " of its " + std::to_string(spec.full_width) +
                                            "x" + std::to_string(spec.full_height) + " pixels"));
    if (const int orientation = spec.get_int_attribute("Orientation", 1); orientation != 1)
        throw InputError(expected_found(where, "a sky image whose first row is the top, left to right",
                                        "orientation " + std::to_string(orientation)));
}

/// From the primaries that the file names. What they have beyond Rec.709's triangle would be negative: cut off.
void to_rec709_pixels(const OIIO::ImageSpec& spec, const std::string& where, FloatImage& image) {
    const OIIO::ParamValue* stored = spec.find_attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8));
    if (stored == nullptr)
        return;
    Chromaticities from;
    for (int i = 0; i < 8; ++i)
        from[static_cast<std::size_t>(i / 2)][i % 2] = static_cast<const float*>(stored->data())[i];
    const glm::dmat3 matrix = to_rec709(from, where);
    if (matrix == glm::dmat3(1))
        return;
    tbb::parallel_for(0, image.height(), [&](int y) {
        for (int x = 0; x < image.width(); ++x) {
            float* p = image.pixel(x, y);
            const glm::dvec3 rgb = glm::max(matrix * glm::dvec3(p[0], p[1], p[2]), glm::dvec3(0));
            for (int c = 0; c < 3; ++c)
                p[c] = static_cast<float>(rgb[c]);
        }
    });
}

void check_pixels(const FloatImage& image, const std::string& where) {
    for (int y = 0; y < image.height(); ++y)
        for (int x = 0; x < image.width(); ++x)
            for (int c = 0; c < 3; ++c)
                if (const float v = image.pixel(x, y)[c]; !std::isfinite(v) || v < 0)
                    throw InputError(
                        expected_found(where + ": pixel (" + std::to_string(x) + ", " + std::to_string(y) + ")",
                                       "radiance that is finite and not negative", std::to_string(v)));
}

}  // namespace

FloatImage read_sky_image(const std::filesystem::path& file) {
    const std::string where = file.string();
    std::string problem;
    const std::unique_ptr<OIIO::ImageInput> input = open_image_file(file, problem);
    if (!input)
        throw InputError(expected_found(where, "a readable sky image", printable(problem)));
    const OIIO::ImageSpec& spec = input->spec();
    check_header(spec, where);
    const int channels = colour_channels(spec, where);
    FloatImage image(spec.width, spec.height, 3);
    constexpr auto stride = static_cast<OIIO::stride_t>(3 * sizeof(float));
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::FLOAT, image.samples().data(), stride))
        throw InputError(expected_found(where, "a whole sky image", printable(input->geterror())));
    if (channels == 1)
        for (std::size_t i = 0; i < image.samples().size(); i += 3)
            image.samples()[i + 1] = image.samples()[i + 2] = image.samples()[i];
    check_pixels(image, where);
    if (channels == 3)
        to_rec709_pixels(spec, where, image);
    return image;
}

}  // namespace equistream
