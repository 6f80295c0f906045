#include "sphere_angles.h"

#include <cmath>

namespace equistream {

SphereAngles::SphereAngles(const EquirectCamera& camera) {
    for (int x = 0; x < camera.width + PlaneNumbers::margin; ++x) {
        const double longitude = camera.range.longitude_min + (x + 0.5) * camera.range.longitude_span() / camera.width;
        sin_longitude_.push_back(float(std::sin(longitude)));
        cos_longitude_.push_back(float(std::cos(longitude)));
    }
    for (int y = 0; y < camera.height; ++y) {
        const double latitude = camera.range.latitude_max - (y + 0.5) * camera.range.latitude_span() / camera.height;
        sin_latitude_.push_back(float(std::sin(latitude)));
        cos_latitude_.push_back(float(std::cos(latitude)));
    }
    for (std::vector<float>& axis : column_world_)
        axis.resize(sin_longitude_.size());
}

void SphereAngles::turn(const glm::dquat& orientation) {
    const glm::dmat3 axes = glm::mat3_cast(orientation);
    for (std::size_t x = 0; x < sin_longitude_.size(); ++x) {
        const glm::dvec3 column = axes * glm::dvec3(sin_longitude_[x], 0, -cos_longitude_[x]);
        for (int axis = 0; axis < 3; ++axis)
            column_world_[axis][x] = float(column[axis]);
    }
    up_world_ = axes[1];
}

SphereRow SphereAngles::row(int y) const {
    const glm::vec3 up(up_world_ * double(sin_latitude(y)));
    return {y, sin_latitude(y), cos_latitude(y), {up.x, up.y, up.z}};
}

}  // namespace equistream
