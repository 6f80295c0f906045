#pragma once
/// Depth of several perspective views at once (OpenGL), and the views.
#include "cluster_culling.h"
#include "scene_geometry.h"

#include <equistream/camera.h>

#include <client/gpu/program.h>
#include <scenes/library/model.h>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace equistream::gl {

// Views that depth is drawn of, as depth_views.glsl has them.

inline constexpr int max_views = 8;

/// What is nearer is not seen, metres.
inline constexpr double near_plane_m = 0.01;

struct DepthViewpoint {
    PerspectiveCamera camera;
    Pose pose;
};

struct ViewBlock {
    glm::mat4 view_from_world;
    glm::vec4 planes[4];
    glm::vec4 scale;
    glm::vec4 size;
};

ViewBlock view_block(const DepthViewpoint& view);

// Depth of several perspective views at once, drawn from a scene's geometry (OpenGL): one pass over all triangles that
// some view may see, into a layer of one depth buffer for each. Alpha masks are respected. The context it was made in
// is current in every call.

class DepthPass {
public:
    explicit DepthPass(const SceneModel& model);

    /// Where all instances are from now on (instance_transforms of scene.h).
    void set_transforms(std::span<const glm::mat4> world_from_object) { geometry_.set_transforms(world_from_object); }

    /// Layer i shows views[i] in its lower rows and columns: row 0 is a view's first. Samples times inverse_scale() are
    /// 1 / planar depth, 0 for a miss. Storage grows and never shrinks. Throws WorkError where the driver has none.
    void draw(std::span<const DepthViewpoint> views, Culling culling = Culling::hidden);

    GLuint texture() const { return depth_.name(); }
    /// Which triangle each texel shows, as depth_fragment.glsl numbers them; 0: none.
    GLuint triangles() const { return triangles_.name(); }
    const SceneGeometry& geometry() const { return geometry_; }
    /// What geometry.glsl, masks.glsl and depth_views.glsl must have defined.
    static std::vector<std::string> geometry_defines();
    static float inverse_scale() { return float(1 / near_plane_m); }
    /// Of the last draw; waits for the GPU.
    DrawnFigures drawn() const { return culling_.drawn(); }
    std::uint64_t triangle_count() const { return geometry_.triangle_count(); }  ///< with instances
    Size size() const { return size_; }

private:
    void size_for(std::span<const DepthViewpoint> views);
    void draw_found(int round) const;

    SceneGeometry geometry_;
    ClusterCulling culling_;
    Program opaque_, masked_;
    Buffer views_;
    VertexArray vertices_;
    Size size_;
    int layers_ = 0;
    Texture depth_, triangles_;
    Framebuffer framebuffer_;
};

}  // namespace equistream::gl
