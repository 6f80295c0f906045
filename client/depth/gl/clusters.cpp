#include "clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <span>

namespace equistream::gl {

namespace {

/// Those of one mesh, sorted so that neighbours in the list are neighbours in space.
void append_mesh(const SceneModel& model, const Mesh& mesh, ClusteredMeshes& all) {
    const auto first_vertex = std::uint32_t(all.positions.size());
    std::vector<std::uint32_t> sorted(mesh.triangles.size() * 3);
    meshopt_spatialSortTriangles(sorted.data(), &mesh.triangles[0].x, sorted.size(), &mesh.positions[0].x,
                                 mesh.positions.size(), sizeof(glm::vec3));
    for (std::size_t at = 0; at < sorted.size(); at += 3 * most_cluster_triangles) {
        const std::span<const std::uint32_t> part =
            std::span(sorted).subspan(at, std::min(3 * most_cluster_triangles, sorted.size() - at));
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

}  // namespace equistream::gl
