#pragma once
/// The limits of cameras, wherever one comes from: the C ABI, Python, an EXR attribute, a manifest or a stream. Their
/// size is held to image.h's limits apart from this. Pure and thread-safe.
#include <equistream/pose_limits.h>

#include <optional>
#include <variant>

namespace equistream {

/// The least angle that a picture covers from side to side. Of narrower ones single precision tells no pixels apart,
/// and all other directions lie many million pixels beyond their borders.
inline constexpr double min_span_rad = 0.001;

/// Nothing if it is the horizontal field of view of some perspective picture.
inline std::optional<Mismatch> fov_mismatch(double fov_x_rad) {
    if (fov_x_rad >= min_span_rad && fov_x_rad <= pi - min_span_rad)
        return std::nullopt;
    return Mismatch{"radians from 0.001 to pi - 0.001", in_words(fov_x_rad)};
}

/// Nothing if it is a range of at least min_span_rad and at most `max_span_rad`, within that of 0.
inline std::optional<Mismatch> span_mismatch(double from_rad, double to_rad, double max_span_rad) {
    constexpr double rounding = 1 + 1e-9;
    const double span_rad = to_rad - from_rad;
    if (from_rad >= -max_span_rad * rounding && to_rad <= max_span_rad * rounding && span_rad >= min_span_rad &&
        span_rad <= max_span_rad * rounding)
        return std::nullopt;
    return Mismatch{"an ascending range in radians, 0.001 to " + in_words(max_span_rad) + " wide",
                    in_words(from_rad) + " to " + in_words(to_rad)};
}

inline std::optional<Mismatch> longitudes_mismatch(double from_rad, double to_rad) {
    return span_mismatch(from_rad, to_rad, 2 * pi);
}

inline std::optional<Mismatch> latitudes_mismatch(double from_rad, double to_rad) {
    if (auto mismatch = span_mismatch(from_rad, to_rad, pi))
        return mismatch;
    constexpr double pole = pi / 2 * (1 + 1e-9);
    if (from_rad >= -pole && to_rad <= pole)
        return std::nullopt;
    return Mismatch{"latitudes from -pi/2 to pi/2", in_words(from_rad) + " to " + in_words(to_rad)};
}

/// Nothing if field of view, longitudes and latitudes are right.
inline std::optional<Mismatch> camera_mismatch(const Camera& camera) {
    if (const auto* perspective = std::get_if<PerspectiveCamera>(&camera))
        return fov_mismatch(perspective->fov_x_rad);
    const LongitudeLatitudeRange& range = std::get<EquirectCamera>(camera).range;
    if (auto mismatch = longitudes_mismatch(range.longitude_min, range.longitude_max))
        return mismatch;
    return latitudes_mismatch(range.latitude_min, range.latitude_max);
}

}  // namespace equistream
