#pragma once
/// Triangles of a polygon in space that need be neither flat nor convex.
#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Appends n - 2 triangles of corner numbers, wound as the polygon is. A quadrangle is cut along the diagonal that
/// leaves both halves facing the same way (the first corner's if both do), larger polygons by clipping ears; one that
/// crosses itself is covered somehow. Takes time in proportion to the square of the corners.
void triangulate(std::span<const glm::vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

}  // namespace equistream
