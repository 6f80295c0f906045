#include "motion.h"

#include <equistream/image_motion.h>

namespace equistream {

Motion::Motion(const Camera& camera, const Pose& here, const Pose& there)
    : camera_(camera), here_(here), there_(there), there_from_world_(glm::conjugate(there.orientation)) {}

glm::dvec2 Motion::difference(glm::dvec2 pixel, const glm::dvec3& direction_there) const {
    const PixelCoordinates<double> here{pixel.x, pixel.y};
    const Vector3<double> d{direction_there.x, direction_there.y, direction_there.z};
    PixelCoordinates<double> motion{};
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera_)) {
        motion = equirect_motion(here, d, sphere->width, sphere->height, sphere->range);
    } else {
        const auto& view = std::get<PerspectiveCamera>(camera_);
        motion = perspective_motion(here, d, view.width, view.height, view.focal_px());
    }
    return {motion.u, motion.v};
}

glm::dvec2 Motion::of_point(glm::dvec2 pixel, const glm::dvec3& position_there_m) const {
    const glm::dvec3 point = there_from_world_ * (position_there_m - there_.position_m);
    const auto* sphere = std::get_if<EquirectCamera>(&camera_);
    return difference(pixel, sphere != nullptr ? sphere->direction_to(point) : point);
}

glm::dvec2 Motion::of_direction(glm::dvec2 pixel) const {
    return difference(pixel, there_from_world_ * (here_.orientation * direction_of(camera_, pixel.x, pixel.y)));
}

}  // namespace equistream
