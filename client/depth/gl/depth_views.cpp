#include "depth_views.h"

#include <equistream/formatted.h>

#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace equistream::gl {

ViewBlock view_block(const DepthViewpoint& view) {
    ViewBlock block;
    const glm::dmat4 turn = glm::mat4_cast(glm::conjugate(view.pose.orientation));
    block.view_from_world = glm::mat4(glm::translate(turn, -view.pose.position_m));
    const double focal = view.camera.focal_px();
    const double edge_x = view.camera.width / (2 * focal), edge_y = view.camera.height / (2 * focal);
    const auto side = [](double x, double y, double edge) {
        return glm::vec4(glm::normalize(glm::dvec3(x, y, -edge)), 0);
    };
    block.planes[0] = side(1, 0, edge_x);
    block.planes[1] = side(-1, 0, edge_x);
    block.planes[2] = side(0, 1, edge_y);
    block.planes[3] = side(0, -1, edge_y);
    // Row 0 is the first: y runs down.
    block.scale = {2 * focal / view.camera.width, -2 * focal / view.camera.height, 0, 0};
    block.size = {view.camera.width, view.camera.height, 0, 0};
    return block;
}

std::vector<std::string> view_defines() {
    return {formatted("MAX_VIEWS %du", max_views), formatted("NEAR_PLANE_M %.9g", near_plane_m)};
}

}  // namespace equistream::gl
