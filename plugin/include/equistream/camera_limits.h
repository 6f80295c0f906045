#pragma once
/// The limits of poses, the IPD, the head box and cameras. They hold for values from any source: the C ABI, Python, an
/// EXR attribute, a manifest, a stream, a viewer or a scene. Readers check a value before they use it. The *_mismatch
/// functions return nothing for a valid value, else the two parts of an error message. Pure and thread-safe.
#include <equistream/camera.h>
#include <equistream/text.h>

#include <cmath>
#include <optional>
#include <string>
#include <variant>

namespace equistream {

/// The largest absolute value of a coordinate in the world. Single-precision numbers are 64 m apart there.
inline constexpr double max_coordinate_m = 1e9;
inline constexpr double max_ipd_m = 10;
inline constexpr double max_head_box_radius_m = 1000;
/// How far a quaternion's length may be from 1.
inline constexpr double max_quaternion_error = 1e-3;

/// Arguments for expected_found(where, expected, found).
struct Mismatch {
    std::string expected, found;
};

/// Whether the value lies within max_coordinate_m. False for NaN.
inline bool is_coordinate(double value_m) {
    return value_m >= -max_coordinate_m && value_m <= max_coordinate_m;
}

inline bool is_position(const glm::dvec3& p) {
    return is_coordinate(p.x) && is_coordinate(p.y) && is_coordinate(p.z);
}

/// Nothing if `value` lies in [min, max]. NaN lies outside.
inline std::optional<Mismatch> range_mismatch(double value, double min, double max) {
    if (value >= min && value <= max)
        return std::nullopt;
    return Mismatch{"a number from " + in_words(min) + " to " + in_words(max), in_words(value)};
}

/// Nothing if every coordinate lies within max_coordinate_m.
inline std::optional<Mismatch> position_mismatch(const glm::dvec3& p) {
    if (is_position(p))
        return std::nullopt;
    return Mismatch{"coordinates from -1e9 to 1e9 metres", in_words(p.x) + " " + in_words(p.y) + " " + in_words(p.z)};
}

/// Nothing if the quaternion is finite and its length differs from 1 by less than max_quaternion_error.
inline std::optional<Mismatch> orientation_mismatch(const glm::dquat& q) {
    const double length = glm::length(q);
    if (std::abs(length - 1) < max_quaternion_error)
        return std::nullopt;
    return Mismatch{"a unit quaternion w x y z", "length " + in_words(length)};
}

/// Nothing if position and orientation are both valid.
inline std::optional<Mismatch> pose_mismatch(const Pose& pose) {
    if (auto mismatch = position_mismatch(pose.position_m))
        return mismatch;
    return orientation_mismatch(pose.orientation);
}

// The limits of cameras. Their width and height in pixels have limits of their own (image.h).

/// Smallest angle between opposite borders of a picture. In a narrower one, single precision cannot distinguish
/// pixels, and directions outside lie many millions of pixels beyond its borders.
inline constexpr double min_span_rad = 0.001;

/// Nothing if a perspective camera can have this horizontal field of view: min_span_rad to pi - min_span_rad.
inline std::optional<Mismatch> fov_mismatch(double fov_x_rad) {
    if (fov_x_rad >= min_span_rad && fov_x_rad <= pi - min_span_rad)
        return std::nullopt;
    return Mismatch{"radians from 0.001 to pi - 0.001", in_words(fov_x_rad)};
}

/// Nothing if the range ascends, spans min_span_rad to `max_span_rad`, and lies within +-`max_span_rad`. Radians.
inline std::optional<Mismatch> span_mismatch(double from_rad, double to_rad, double max_span_rad) {
    constexpr double rounding = 1 + 1e-9;
    const double span_rad = to_rad - from_rad;
    if (from_rad >= -max_span_rad * rounding && to_rad <= max_span_rad * rounding && span_rad >= min_span_rad &&
        span_rad <= max_span_rad * rounding)
        return std::nullopt;
    return Mismatch{"an ascending range in radians, 0.001 to " + in_words(max_span_rad) + " wide",
                    in_words(from_rad) + " to " + in_words(to_rad)};
}

/// Longitudes may lie from -2 pi to 2 pi and span 2 pi.
inline std::optional<Mismatch> longitudes_mismatch(double from_rad, double to_rad) {
    return span_mismatch(from_rad, to_rad, 2 * pi);
}

/// Latitudes lie from -pi/2 to pi/2.
inline std::optional<Mismatch> latitudes_mismatch(double from_rad, double to_rad) {
    if (auto mismatch = span_mismatch(from_rad, to_rad, pi))
        return mismatch;
    constexpr double pole = pi / 2 * (1 + 1e-9);
    if (from_rad >= -pole && to_rad <= pole)
        return std::nullopt;
    return Mismatch{"latitudes from -pi/2 to pi/2", in_words(from_rad) + " to " + in_words(to_rad)};
}

/// Nothing if the field of view, or the longitudes and latitudes, are valid.
inline std::optional<Mismatch> camera_mismatch(const Camera& camera) {
    if (const auto* perspective = std::get_if<PerspectiveCamera>(&camera))
        return fov_mismatch(perspective->fov_x_rad);
    const LongitudeLatitudeRange& range = std::get<EquirectCamera>(camera).range;
    if (auto mismatch = longitudes_mismatch(range.longitude_min, range.longitude_max))
        return mismatch;
    return latitudes_mismatch(range.latitude_min, range.latitude_max);
}

}  // namespace equistream
