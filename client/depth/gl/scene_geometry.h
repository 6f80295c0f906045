#pragma once
/// A scene's triangles, masks and instances as shaders read them (geometry.glsl, masks.glsl). The context it was made
/// in is current in every call.
#include <client/gpu/objects.h>
#include <scenes/library/model.h>

#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace equistream::gl {

class SceneGeometry {
public:
    /// Uploads positions, triangles and masks; shading data is not read.
    explicit SceneGeometry(const SceneModel& model);

    /// Where all instances are from now on (instance_transforms of scene.h).
    void set_transforms(std::span<const glm::mat4> world_from_object);

    /// Storage blocks 0 to 7: what geometry.glsl and masks.glsl read, and positions, texture coordinates and indices at
    /// 2, 3 and 4.
    void bind() const;
    /// What those files must have defined.
    static std::vector<std::string> defines();

    /// Clusters of all instances.
    std::uint32_t item_count() const { return item_count_; }
    bool has_masks() const { return has_masks_; }
    std::uint64_t triangle_count() const { return triangle_count_; }  ///< with instances
    GLuint items() const { return items_.name(); }
    GLuint transforms() const { return transforms_.name(); }
    /// By which each instance's transform may make lengths grow.
    GLuint growth() const { return growth_.name(); }
    GLuint instance_masks() const { return instance_masks_.name(); }
    GLuint positions() const { return positions_.name(); }  ///< three floats each
    GLuint uvs() const { return uvs_.name(); }              ///< two floats each, where there are masks
    GLuint indices() const { return indices_.name(); }

private:
    void upload_masks(const SceneModel& model);

    std::uint64_t triangle_count_ = 0;
    std::uint32_t item_count_ = 0, instance_count_ = 0;
    bool has_masks_ = false;
    std::vector<float> lengths_growth_;  ///< memory of set_transforms
    Buffer items_, transforms_, growth_, positions_, uvs_, indices_, instance_masks_, masks_, mask_bits_;
};

// A scene's triangles in clusters that lie close together, so that what a view does not see need not be drawn.

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
