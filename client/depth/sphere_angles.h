#pragma once
/// Sines and cosines of a sphere's columns and rows, and its columns' part of directions in the world. Internal to
/// depth reuse.
#include "sphere_warp.h"

#include <equistream/camera.h>

#include <vector>

namespace equistream {

/// In rows nearer a pole than this longitudes turn too fast to be carried.
inline constexpr float least_cos_latitude = 0.1f;

class SphereAngles {
public:
    explicit SphereAngles(const EquirectCamera& camera);

    /// Of the sphere's axes from now on.
    void turn(const glm::dquat& orientation);

    /// By column; some beyond the last for whole registers.
    const float* sin_longitude() const { return sin_longitude_.data(); }
    const float* cos_longitude() const { return cos_longitude_.data(); }
    const float* column_world(int axis) const { return column_world_[axis].data(); }
    float sin_latitude(int y) const { return sin_latitude_[std::size_t(y)]; }
    float cos_latitude(int y) const { return cos_latitude_[std::size_t(y)]; }
    bool is_polar(int y) const { return cos_latitude(y) < least_cos_latitude; }
    SphereRow row(int y) const;

private:
    std::vector<float> sin_longitude_, cos_longitude_, sin_latitude_, cos_latitude_;
    std::vector<float> column_world_[3];
    glm::dvec3 up_world_{0, 1, 0};
};

}  // namespace equistream
