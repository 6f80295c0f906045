#pragma once
/// Vertices that lie at one point, and triangles with only the vertices they use.
#include "head_boxes.h"

#include <span>
#include <vector>

namespace equistream {

/// For each position the number of its point: equal positions (bit by bit) have one. Points are numbered from 0 in the
/// order of their first position.
std::vector<std::uint32_t> weld(std::span<const glm::vec3> positions);

/// A mesh of these triangles of another, with the vertices that they use, in order.
Mesh part_of(const Mesh& mesh, std::span<const glm::uvec3> triangles);

inline TriangleCorners corners_of(const Mesh& mesh, std::size_t triangle, const glm::mat4& world_from_object) {
    const glm::uvec3 t = mesh.triangles[triangle];
    const auto at = [&](unsigned i) { return glm::vec3(world_from_object * glm::vec4(mesh.positions[i], 1)); };
    return {at(t.x), at(t.y), at(t.z)};
}

}  // namespace equistream
