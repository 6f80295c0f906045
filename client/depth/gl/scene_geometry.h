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
    /// Of one cluster of triangles that lie close together, so that what a view does not see need not be drawn.
    static constexpr std::size_t max_cluster_triangles = 256;

    /// Uploads positions, triangles and masks; shading data is not read.
    explicit SceneGeometry(const SceneModel& model);

    /// Where all instances are from now on (instance_transforms of scene.h).
    void set_transforms(std::span<const glm::mat4> world_from_object);

    /// Storage blocks 0 to 7: what geometry.glsl and masks.glsl read, and positions, texture coordinates and indices at
    /// 2, 3 and 4.
    void bind() const;

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

/// By how much a transform may make a length grow: its largest singular value, never from below.
float length_growth(const glm::mat4& transform);

}  // namespace equistream::gl
