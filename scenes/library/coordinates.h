#pragma once
/// How far from the origin anything may be: as far as the C ABI takes poses, where floats are still 64 m apart.
#include <glm/glm.hpp>

namespace equistream {

inline constexpr double largest_coordinate_m = 1e9;

/// False too for what is not a number.
inline bool is_coordinate(double value_m) {
    return value_m >= -largest_coordinate_m && value_m <= largest_coordinate_m;
}

inline bool is_position(const glm::dvec3& p) {
    return is_coordinate(p.x) && is_coordinate(p.y) && is_coordinate(p.z);
}

}  // namespace equistream
