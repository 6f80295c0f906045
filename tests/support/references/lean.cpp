#include "plain_task.h"

#include <client/warp/source_depth_engine.h>

#include <cmath>

namespace equistream::plain {

/// Where each ray of the eye leaves the sphere of pictures.
void find_by_lean(const PlainTask& task, Image<double>& inverse_planar) {
    const double radius_m = proxy_radius_m(task.source, task.options);
    const glm::dvec3 from = task.eye_from_source_m();
    for (int y = 0; y < inverse_planar.height(); ++y)
        for (int x = 0; x < inverse_planar.width(); ++x) {
            const glm::dvec3 own = task.eye.camera.direction(x + 0.5, y + 0.5);
            const glm::dvec3 ray = task.eye.pose.orientation * own;
            const double along = glm::dot(from, ray);
            const double distance_m = -along + std::sqrt(along * along - glm::dot(from, from) + radius_m * radius_m);
            *inverse_planar.pixel(x, y) = distance_m > 0 ? 1 / (distance_m * -own.z) : -1;
        }
}

}  // namespace equistream::plain
