#include "motion.h"

#include <cmath>

namespace equistream {
namespace {

/// The image point of a direction, kept within farther_px() of the centre.
glm::dvec2 limited_pixel(const PerspectiveCamera& camera, const glm::dvec3& d) {
    const double limit = Motion::farther_px(camera);
    const double aside = std::hypot(d.x, d.y);
    if (-d.z * limit > aside * camera.focal_px())
        return camera.pixel(d);
    const glm::dvec2 centre(0.5 * camera.width, 0.5 * camera.height);
    // Straight behind there is no direction to prefer.
    const glm::dvec2 outwards = aside > 0 ? glm::dvec2(d.x, -d.y) / aside : glm::dvec2(1, 0);
    return centre + limit * outwards;
}

}  // namespace

Motion::Motion(const Camera& camera, const Pose& here, const Pose& there)
    : camera_(camera), here_(here), there_(there), there_from_world_(glm::conjugate(there.orientation)) {}

double Motion::farther_px(const PerspectiveCamera& camera) {
    return 8 * std::hypot(camera.width, camera.height);
}

glm::dvec2 Motion::difference(glm::dvec2 pixel, const glm::dvec3& direction_there) const {
    if (const auto* sphere = std::get_if<EquirectCamera>(&camera_)) {
        const glm::dvec2 d = sphere->pixel(direction_there) - pixel;
        return {shortest_column_difference(d.x, sphere->width, sphere->range), d.y};
    }
    return limited_pixel(std::get<PerspectiveCamera>(camera_), direction_there) - pixel;
}

glm::dvec2 Motion::of_point(glm::dvec2 pixel, const glm::dvec3& position_there_m) const {
    return difference(pixel, there_from_world_ * (position_there_m - there_.position_m));
}

glm::dvec2 Motion::of_direction(glm::dvec2 pixel) const {
    return difference(pixel, there_from_world_ * (here_.orientation * direction_of(camera_, pixel.x, pixel.y)));
}

}  // namespace equistream
