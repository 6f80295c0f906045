#include "images.h"

#include <equistream/error.h>

#include <Imath/half.h>

#include <array>
#include <cstring>
#include <limits>
#include <string>

namespace equistream {

namespace {

std::size_t pixel_bytes(es_pixel_format format) {
    return format == ES_RGBA_HALF ? 8 : 4;
}

std::size_t stride_of(std::size_t given, std::size_t bytes, const SessionRequest& request) {
    return given != 0 ? given : bytes * std::size_t(request.width);
}

void require_stride(const std::string& field, std::size_t given, std::size_t bytes, const SessionRequest& request) {
    const std::size_t least = bytes * std::size_t(request.width);
    if (given != 0 && given < least)
        throw InputError(
            expected_found(field, "0, or at least " + std::to_string(least) + " bytes", std::to_string(given)));
}

/// By the 8 bits of a sample, as half floats from 0 to 1.
const std::array<std::uint16_t, 256>& halves() {
    static const std::array<std::uint16_t, 256> table = [] {
        std::array<std::uint16_t, 256> made{};
        for (std::size_t i = 0; i < made.size(); ++i)
            made[i] = Imath::half(float(i) / 255).bits();
        return made;
    }();
    return table;
}

void write_pixels(const ByteImage& rgba, const ViewPart& part, const SessionRequest& request, es_eye_image& image) {
    const std::size_t stride = stride_of(image.pixels_stride, pixel_bytes(image.format), request);
    const std::size_t samples = 4 * std::size_t(part.width);
    for (int y = 0; y < part.height; ++y) {
        const std::uint8_t* from = rgba.pixel(part.left, part.top + y);
        char* to = static_cast<char*>(image.pixels) + stride * std::size_t(y);
        if (image.format == ES_RGBA8) {
            std::memcpy(to, from, samples);
            continue;
        }
        for (std::size_t i = 0; i < samples; ++i)
            std::memcpy(to + 2 * i, &halves()[from[i]], 2);
    }
}

/// `plane` may be empty: it is not known.
template <typename Sample, typename View>
void write_plane(const View& plane, Sample unknown, const ViewPart& part, Sample* to, std::size_t stride) {
    for (int y = 0; y < part.height; ++y) {
        Sample* row = reinterpret_cast<Sample*>(reinterpret_cast<char*>(to) + stride * std::size_t(y));
        if (plane.empty())
            std::fill_n(row, part.width, unknown);
        else
            std::copy_n(plane.pixel(part.left, part.top + y), part.width, row);
    }
}

}  // namespace

void require_images(std::span<const es_eye_image, 2> images, const SessionRequest& request) {
    for (std::size_t i = 0; i < images.size(); ++i) {
        const es_eye_image& image = images[i];
        const std::string field = "images[" + std::to_string(i) + "].";
        if (image.struct_size < sizeof(es_eye_image))
            throw InputError(expected_found(field + "struct_size", "at least " + std::to_string(sizeof(es_eye_image)),
                                            std::to_string(image.struct_size)));
        int format = 0;
        std::memcpy(&format, &image.format, sizeof format);
        if (format != ES_RGBA8 && format != ES_RGBA_HALF)
            throw InputError(expected_found(field + "format", "ES_RGBA8 or ES_RGBA_HALF", std::to_string(format)));
        require_stride(field + "pixels_stride", image.pixels_stride, pixel_bytes(image.format), request);
        require_stride(field + "origin_stride", image.origin_stride, 1, request);
        require_stride(field + "depth_stride", image.depth_stride, sizeof(float), request);
        require_stride(field + "confidence_stride", image.confidence_stride, 1, request);
        if (image.depth_stride % alignof(float) != 0)
            throw InputError(
                expected_found(field + "depth_stride", "a multiple of 4", std::to_string(image.depth_stride)));
    }
}

void write_image(const PipelineEye& eye, const ViewPart& part, const SessionRequest& request, es_eye_image& image) {
    image.width = part.width;
    image.height = part.height;
    image.fov = fov_of(part.fov);
    if (image.pixels != nullptr)
        write_pixels(eye.picture.rgba, part, request, image);
    if (image.origin != nullptr)
        write_plane(eye.picture.origin, std::uint8_t{ES_ORIGIN_GAP}, part, image.origin,
                    stride_of(image.origin_stride, 1, request));
    if (image.depth_m != nullptr) {
        const ImageView<const float> depth_m = eye.depth_view();
        struct Plane {
            const ImageView<const float>& view;
            bool empty() const { return view.data == nullptr; }
            const float* pixel(int x, int y) const { return view.pixel(x, y); }
        };
        write_plane(Plane{depth_m}, std::numeric_limits<float>::quiet_NaN(), part, image.depth_m,
                    stride_of(image.depth_stride, sizeof(float), request));
    }
    if (image.confidence != nullptr)
        write_plane(eye.picture.reliability, std::uint8_t{0}, part, image.confidence,
                    stride_of(image.confidence_stride, 1, request));
}

es_field_of_view fov_of(const FieldOfView& fov) {
    return {fov.left_rad, fov.right_rad, fov.up_rad, fov.down_rad};
}

}  // namespace equistream
