#include "clusters.h"

#include <meshoptimizer.h>

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <span>

namespace equistream::gl {

namespace {

/// Those of one mesh, sorted so that neighbours in the list are neighbours in space.
void append_mesh(const SceneModel& model, const Mesh& mesh, ClusteredMeshes& all) {
    const auto first_vertex = std::uint32_t(all.positions.size());
    std::vector<std::uint32_t> sorted(mesh.triangles.size() * 3);
    meshopt_spatialSortTriangles(sorted.data(), &mesh.triangles[0].x, sorted.size(), &mesh.positions[0].x,
                                 mesh.positions.size(), sizeof(glm::vec3));
    for (std::size_t at = 0; at < sorted.size(); at += 3 * max_cluster_triangles) {
        const std::span<const std::uint32_t> part =
            std::span(sorted).subspan(at, std::min(3 * max_cluster_triangles, sorted.size() - at));
        const meshopt_Bounds bounds = meshopt_computeClusterBounds(part.data(), part.size(), &mesh.positions[0].x,
                                                                   mesh.positions.size(), sizeof(glm::vec3));
        all.clusters.push_back({std::uint32_t(all.indices.size()),
                                std::uint32_t(part.size()),
                                {bounds.center[0], bounds.center[1], bounds.center[2]},
                                bounds.radius});
        for (const std::uint32_t index : part)
            all.indices.push_back(first_vertex + index);
    }
    all.positions.insert(all.positions.end(), mesh.positions.begin(), mesh.positions.end());
    if (model.mask_of(mesh) == no_index)
        return;
    all.uvs.resize(first_vertex);
    all.uvs.insert(all.uvs.end(), mesh.uvs.begin(), mesh.uvs.end());
}

/// Of a symmetric matrix, in closed form: it is q + p B where B has trace 0 and 6 for its squares' sum, so that its
/// eigenvalues are 2 cos(phi), 3 phi the arc cosine of half its determinant.
double max_eigenvalue(const glm::dmat3& a) {
    const double q = (a[0][0] + a[1][1] + a[2][2]) / 3;
    const glm::dmat3 rest = a - glm::dmat3(q);
    const double p =
        std::sqrt((glm::dot(rest[0], rest[0]) + glm::dot(rest[1], rest[1]) + glm::dot(rest[2], rest[2])) / 6);
    if (!(p > 0))
        return q;
    const double half = std::clamp(glm::determinant(rest * (1 / p)) / 2, -1.0, 1.0);
    return q + 2 * p * std::cos(std::acos(half) / 3);
}

}  // namespace

ClusteredMeshes cluster_meshes(const SceneModel& model) {
    ClusteredMeshes all;
    for (const Mesh& mesh : model.meshes) {
        const auto first = std::uint32_t(all.clusters.size());
        if (!mesh.triangles.empty())
            append_mesh(model, mesh, all);
        all.of_mesh.push_back({first, std::uint32_t(all.clusters.size()) - first});
    }
    if (!all.uvs.empty())
        all.uvs.resize(all.positions.size());
    return all;
}

float length_growth(const glm::mat4& transform) {
    constexpr double above_rounding = 1 + 1e-6;
    const glm::dmat3 m(transform);
    return float(above_rounding * std::sqrt(max_eigenvalue(glm::transpose(m) * m)));
}

}  // namespace equistream::gl
