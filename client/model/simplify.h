#pragma once
/// Fewer triangles within a displacement. Vertices stay where they are: what is left uses some of them.
#include "head_boxes.h"

#include <span>
#include <vector>

namespace equistream {

/// Triangles of a mesh, with edges that nothing borders on left alone; `allowed_m` in the positions' unit. It is held
/// to as meshoptimizer estimates it, a mean over planes; what that lets through, rays have to find.
std::vector<glm::uvec3> simplified(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles,
                                   double allowed_m);

/// Geometry in world space whose vertices are welded. Strictness is by vertex: triangles at vertices of strictness n
/// may move by 4^-n of what the bound allows, from `exact` on not at all.
struct StaticGeometry {
    static constexpr std::uint8_t exact = 3;

    std::vector<glm::vec3> positions;
    std::vector<std::uint8_t> strictness;
    std::vector<glm::uvec3> triangles;
};

/// By clusters whose size goes with their distance, so that each has one allowance; clusters' borders stay in one pass
/// and lie elsewhere in the next, so there are no cracks, nor seams that stay fine.
std::vector<glm::uvec3> simplified(const StaticGeometry& geometry, const HeadBoxes& boxes, double error_rad);

// Vertices that lie at one point, and triangles with only the vertices they use.

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
