#pragma once
/// Depth of several perspective views at once, drawn from a scene's geometry (OpenGL): one pass over all triangles that
/// some view may see, into a layer of one depth buffer for each. Alpha masks are respected. The context it was made in
/// is current in every call.
#include "clusters.h"

#include <gl/program.h>

#include <equistream/camera.h>
#include <equistream_scene/model.h>

#include <glm/mat4x4.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace equistream::gl {

inline constexpr int most_views = 8;

/// What is nearer is not seen, metres.
inline constexpr double near_plane_m = 0.01;

struct DepthViewpoint {
    PerspectiveCamera camera;
    Pose pose;
};

struct DrawnFigures {
    std::uint32_t draws = 0;      ///< clusters times views
    std::uint32_t triangles = 0;  ///< times views
};

class DepthPass {
public:
    /// Uploads positions, triangles and masks; shading data is not read.
    explicit DepthPass(const SceneModel& model);

    /// Where all instances are from now on (instance_transforms of scene.h).
    void set_transforms(std::span<const glm::mat4> world_from_object);

    /// Layer i shows views[i] in its lower rows and columns: row 0 is a view's first. Samples times inverse_scale() are
    /// 1 / planar depth, 0 for a miss. Storage grows and never shrinks. Throws WorkError where the driver has none.
    void draw(std::span<const DepthViewpoint> views);

    GLuint texture() const { return depth_.name(); }
    /// Which triangle each texel shows, as depth_fragment.glsl numbers them; 0: none. bind_geometry is how to find it.
    GLuint triangles() const { return triangles_.name(); }
    /// Binds what geometry.glsl and masks.glsl read, and positions, texture coordinates and indices at 2, 3 and 4.
    void bind_geometry() const;
    /// What those files must have defined.
    static std::vector<std::string> geometry_defines();
    static float inverse_scale() { return float(1 / near_plane_m); }
    /// Of the last draw; waits for the GPU.
    DrawnFigures drawn() const;
    std::uint64_t triangle_count() const { return triangle_count_; }  ///< with instances
    Size size() const { return size_; }

private:
    void upload_masks(const SceneModel& model);
    void size_for(std::span<const DepthViewpoint> views);
    void cull(std::size_t views);
    void draw_list(const Program& program, const Buffer& commands, GLintptr count_offset) const;

    Program cull_, opaque_, masked_;
    std::uint64_t triangle_count_ = 0;
    std::uint32_t item_count_ = 0, instance_count_ = 0;
    bool has_masks_ = false;
    Buffer items_, transforms_, growth_, opaque_commands_, masked_commands_, counts_, views_;
    Buffer positions_, uvs_, indices_, identities_, instance_masks_, masks_, mask_bits_;
    VertexArray vertices_;
    Size size_;
    int layers_ = 0;
    Texture depth_, triangles_;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
