#pragma once
/// Views that depth is drawn of, as depth_views.glsl has them.
#include <equistream/camera.h>

#include <glm/mat4x4.hpp>
#include <glm/vec4.hpp>

#include <string>
#include <vector>

namespace equistream::gl {

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

/// What depth_views.glsl must have defined.
std::vector<std::string> view_defines();

}  // namespace equistream::gl
