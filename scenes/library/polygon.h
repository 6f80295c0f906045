#pragma once
/// Triangles of a polygon in space that need be neither flat nor convex.
#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Appends n - 2 triangles of corner numbers, wound as the polygon is. A quadrangle is cut along the diagonal that
/// leaves both halves facing the same way (the first corner's if both do), larger polygons by clipping ears; one that
/// crosses itself is covered somehow. Takes time in proportion to the square of the corners.
void triangulate(std::span<const glm::vec3> corners, std::vector<std::array<std::uint32_t, 3>>& triangles);

// Distance from a point to a triangle.

/// Ericson, Real-Time Collision Detection, 5.1.5: the region of the triangle that p projects into. Triangles without
/// area are segments or points.
inline double distance_to_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
    const auto to_segment = [&](const glm::dvec3& s, const glm::dvec3& e) {
        const glm::dvec3 d = e - s;
        const double length_squared = glm::dot(d, d);
        const double t = length_squared > 0 ? glm::clamp(glm::dot(p - s, d) / length_squared, 0.0, 1.0) : 0;
        return glm::length(p - s - t * d);
    };
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const auto left_of = [&](const glm::dvec3& s, const glm::dvec3& e) {
        return glm::dot(glm::cross(e - s, p - s), normal) >= 0;
    };
    const double area = glm::length(normal);
    if (area > 0 && left_of(a, b) && left_of(b, c) && left_of(c, a))
        return std::abs(glm::dot(p - a, normal)) / area;
    return std::min({to_segment(a, b), to_segment(b, c), to_segment(c, a)});
}

}  // namespace equistream
