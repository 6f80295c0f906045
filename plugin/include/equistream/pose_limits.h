#pragma once
/// The limits of poses, of the IPD and of the head box. They hold wherever a value comes from: the C ABI, Python, an
/// EXR attribute, a manifest, a stream, a viewer or a scene. A reader checks a value before it uses it and words the
/// complaint with the mismatch, which names what was expected and what was found. Pure and thread-safe.
#include <equistream/camera.h>
#include <equistream/formatted.h>

#include <cmath>
#include <optional>
#include <string>

namespace equistream {

/// The largest absolute value of a coordinate in the world. Single-precision numbers are 64 m apart there.
inline constexpr double max_coordinate_m = 1e9;
inline constexpr double max_ipd_m = 10;
inline constexpr double max_head_box_radius_m = 1000;
/// How far a quaternion's length may be from 1.
inline constexpr double max_quaternion_error = 1e-3;

/// Both parts of expected_found(where, expected, found).
struct Mismatch {
    std::string expected, found;
};

/// False for NaN too.
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

/// Nothing if the quaternion is finite and of length 1.
inline std::optional<Mismatch> orientation_mismatch(const glm::dquat& q) {
    const double length = glm::length(q);
    if (std::abs(length - 1) < max_quaternion_error)
        return std::nullopt;
    return Mismatch{"a unit quaternion w x y z", "length " + in_words(length)};
}

/// Nothing if position and orientation are both right.
inline std::optional<Mismatch> pose_mismatch(const Pose& pose) {
    if (auto mismatch = position_mismatch(pose.position_m))
        return mismatch;
    return orientation_mismatch(pose.orientation);
}

}  // namespace equistream
