#pragma once
/// Distance from a point to a triangle.
#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>

namespace equistream {

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
