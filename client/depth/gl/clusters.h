#pragma once
/// A scene's triangles in clusters that lie close together, so that what a view does not see need not be drawn.
#include <scenes/library/model.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace equistream::gl {

inline constexpr std::size_t max_cluster_triangles = 256;

/// Triangles [first_index, first_index + index_count) of ClusteredMeshes::indices, within a ball in the mesh's axes.
struct Cluster {
    std::uint32_t first_index = 0, index_count = 0;
    glm::vec3 centre{0};
    float radius = 0;
};

/// All meshes of a model, one after the other; a mesh without triangles has no cluster.
struct ClusteredMeshes {
    struct Range {
        std::uint32_t first = 0, count = 0;
    };
    std::vector<glm::vec3> positions;
    std::vector<glm::vec2> uvs;  ///< empty unless a mesh is cut by a mask; zeros for those that are not
    std::vector<std::uint32_t> indices;
    std::vector<Cluster> clusters;
    std::vector<Range> of_mesh;  ///< its clusters
};

ClusteredMeshes cluster_meshes(const SceneModel& model);

/// By how much a transform may make a length grow: its largest singular value, never from below.
float length_growth(const glm::mat4& transform);

}  // namespace equistream::gl
