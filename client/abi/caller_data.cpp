#include "caller_data.h"

#include <equistream/camera_limits.h>
#include <equistream/error.h>

#include <client/stages/stages.h>

#include <Imath/half.h>

#include <tbb/parallel_for.h>

#include <array>
#include <limits>

namespace equistream {

namespace {

constexpr int max_eye_side = 16384;
constexpr std::size_t max_text = 65536;

void require(bool right, const std::string& field, const std::string& expected, const std::string& found) {
    if (!right)
        throw InputError(expected_found(field, expected, found));
}

void require(const std::optional<Mismatch>& mismatch, const std::string& field) {
    if (mismatch)
        throw InputError(expected_found(field, mismatch->expected, mismatch->found));
}

std::string checked_text(const char* field, const char* text) {
    if (text == nullptr)
        return "";
    require(strnlen(text, max_text + 1) <= max_text, field, "at most " + std::to_string(max_text) + " bytes", "more");
    return text;
}

FieldOfView checked_fov(const std::string& field, const es_field_of_view& fov) {
    constexpr double max_rad = 85 * pi / 180, min_span_rad = 1e-3;
    for (const double angle : {fov.left, fov.right, fov.up, fov.down})
        require(range_mismatch(angle, -max_rad, max_rad), field);
    require(fov.right - fov.left >= min_span_rad && fov.up - fov.down >= min_span_rad, field,
            "left < right and down < up, at least 0.001 rad apart", "less, or the other order");
    return {fov.left, fov.right, fov.up, fov.down};
}

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
    tbb::parallel_for(0, part.height, [&](int y) {
        const std::uint8_t* from = rgba.pixel(part.left, part.top + y);
        char* to = static_cast<char*>(image.pixels) + stride * std::size_t(y);
        if (image.format == ES_RGBA8) {
            std::memcpy(to, from, samples);
            return;
        }
        for (std::size_t i = 0; i < samples; ++i)
            std::memcpy(to + 2 * i, &halves()[from[i]], 2);
    });
}

/// `plane` may be empty: it is not known.
template <typename Sample>
void write_plane(const ImageView<const Sample>& plane, Sample unknown, const ViewPart& part, Sample* to,
                 std::size_t stride) {
    tbb::parallel_for(0, part.height, [&](int y) {
        Sample* row = reinterpret_cast<Sample*>(reinterpret_cast<char*>(to) + stride * std::size_t(y));
        if (plane.width == 0)
            std::fill_n(row, part.width, unknown);
        else
            std::copy_n(plane.pixel(part.left, part.top + y), part.width, row);
    });
}

}  // namespace

Pose checked_pose(const std::string& field, const es_pose& pose) {
    const double* p = pose.position_m;
    const double* q = pose.orientation_wxyz;
    const glm::dvec3 position_m(p[0], p[1], p[2]);
    const glm::dquat orientation(q[0], q[1], q[2], q[3]);
    require(position_mismatch(position_m), field + ".position_m");
    require(orientation_mismatch(orientation), field + ".orientation_wxyz");
    return {position_m, orientation / glm::length(orientation)};
}

SessionSettings checked_settings(const es_client_settings* settings) {
    const std::size_t sizes[] = {sizeof(es_client_settings)};
    const es_client_settings s = whole_struct(settings, "es_client_settings", sizes);
    require(s.abi_version == ES_CLIENT_ABI_VERSION, "abi_version", std::to_string(ES_CLIENT_ABI_VERSION),
            std::to_string(s.abi_version));
    int backend = 0;  // a C caller may store any int in an enum
    std::memcpy(&backend, &s.backend, sizeof backend);
    require(backend == ES_BACKEND_CPU || backend == ES_BACKEND_OPENGL, "backend", "ES_BACKEND_CPU or ES_BACKEND_OPENGL",
            std::to_string(backend));
    SessionSettings session;
    session.by_gl = backend == ES_BACKEND_OPENGL;
    session.source = checked_text("source", s.source);
    require(!session.source.empty(), "source", "a file, a folder or a URL", s.source == nullptr ? "NULL" : "no text");
    session.scene = checked_text("scene", s.scene);
    session.engine = checked_text("engine", s.engine);
    if (s.fill != nullptr)
        session.fill = checked_text("fill", s.fill);
    if (s.mirrors != nullptr)
        session.mirrors = find_mirror_treatment(checked_text("mirrors", s.mirrors), "mirrors");
    session.confidence = s.confidence != 0;
    session.paused = s.paused != 0;
    session.loop = s.loop != 0;
    session.hardware = s.software == 0;
    require(range_mismatch(s.max_extrapolation_s, 0, 1), "max_extrapolation_s");
    session.max_extrapolation_s = s.max_extrapolation_s;
    require(range_mismatch(s.exposure_stops, -max_exposure_stops, max_exposure_stops), "exposure_stops");
    session.exposure_stops = s.exposure_stops;
    return session;
}

SessionRequest checked_request(const es_client_request* request) {
    const std::size_t sizes[] = {sizeof(es_client_request)};
    const es_client_request r = whole_struct(request, "es_client_request", sizes);
    require(range_mismatch(r.display_s, 0, 1e9), "display_s");
    SessionRequest checked;
    checked.display_s = r.display_s;
    checked.head = checked_pose("head", r.head);
    for (int i = 0; i < 2; ++i) {
        const std::string field = "eyes[" + std::to_string(i) + "]";
        checked.eyes[std::size_t(i)] = {checked_pose(field + ".in_head", r.eyes[i].in_head),
                                        checked_fov(field + ".fov", r.eyes[i].fov)};
    }
    for (const auto& [field, side] : {std::pair{"width", r.width}, {"height", r.height}})
        require(side >= 1 && side <= max_eye_side, field, "1 to " + std::to_string(max_eye_side), std::to_string(side));
    checked.width = r.width;
    checked.height = r.height;
    return checked;
}

void require_exact_size(const std::string& name, std::size_t expected, std::size_t found) {
    if (found != expected)
        throw InputError(expected_found(name + ".struct_size", std::to_string(expected), std::to_string(found)));
}

void require_images(std::span<const es_eye_image, 2> images, const SessionRequest& request) {
    for (std::size_t i = 0; i < images.size(); ++i) {
        const es_eye_image& image = images[i];
        const std::string name = "images[" + std::to_string(i) + "]", field = name + ".";
        require_exact_size(name, sizeof image, image.struct_size);
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

// Hosts and files have these numbers.
static_assert(int(PixelOrigin::gap) == ES_ORIGIN_GAP && int(PixelOrigin::source) == ES_ORIGIN_SOURCE &&
              int(PixelOrigin::small) == ES_ORIGIN_SMALL && int(PixelOrigin::neighbours) == ES_ORIGIN_NEIGHBOURS &&
              int(PixelOrigin::earlier) == ES_ORIGIN_EARLIER && int(PixelOrigin::patches) == ES_ORIGIN_PATCHES &&
              int(PixelOrigin::hidden) == ES_ORIGIN_HIDDEN && int(PixelOrigin::geometry) == ES_ORIGIN_GEOMETRY &&
              int(PixelOrigin::push_pull) == ES_ORIGIN_PUSH_PULL && int(PixelOrigin::base) == ES_ORIGIN_BASE &&
              pixel_origin_count == ES_ORIGIN_BASE + 1);

void write_image(const PipelineEye& eye, const ViewPart& part, const SessionRequest& request, es_eye_image& image) {
    image.width = part.width;
    image.height = part.height;
    image.fov = fov_of(part.fov);
    if (image.pixels != nullptr)
        write_pixels(eye.picture.rgba, part, request, image);
    if (image.origin != nullptr)
        write_plane(eye.picture.origin.view(), std::uint8_t{ES_ORIGIN_GAP}, part, image.origin,
                    stride_of(image.origin_stride, 1, request));
    if (image.depth_m != nullptr)
        write_plane(eye.depth_view(), std::numeric_limits<float>::quiet_NaN(), part, image.depth_m,
                    stride_of(image.depth_stride, sizeof(float), request));
    if (image.confidence != nullptr)
        write_plane(eye.picture.reliability.view(), std::uint8_t{0}, part, image.confidence,
                    stride_of(image.confidence_stride, 1, request));
}

es_field_of_view fov_of(const FieldOfView& fov) {
    return {fov.left_rad, fov.right_rad, fov.up_rad, fov.down_rad};
}

}  // namespace equistream
