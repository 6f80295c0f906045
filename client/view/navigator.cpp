#include "navigator.h"

#include <equistream/conventions.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

/// Of a box, beyond which nothing is left of what it was made for.
constexpr double fade_radii = 0.5, min_fade_m = 0.25;

double towards(double from, double to, double most) {
    return from + std::clamp(to - from, -most, most);
}

}  // namespace

void Navigator::steer(const Steering& steering, double seconds) {
    const auto pair = [&](Action positive, Action negative) {
        return double(steering.is_held(positive)) - double(steering.is_held(negative));
    };
    yaw_rad_ += steering.drag_yaw_rad +
                seconds * turn_rad_per_s * (pair(Action::turn_left, Action::turn_right) - steering.turn_x);
    yaw_rad_ = std::remainder(yaw_rad_, 2 * pi);
    pitch_rad_ += steering.drag_pitch_rad +
                  seconds * turn_rad_per_s * (pair(Action::turn_up, Action::turn_down) - steering.turn_y);
    pitch_rad_ = std::clamp(pitch_rad_, -pi / 2, pi / 2);

    const glm::dvec3 wanted(pair(Action::move_right, Action::move_left) + steering.move_x,
                            pair(Action::move_up, Action::move_down) + steering.move_y,
                            pair(Action::move_back, Action::move_forward) + steering.move_z);
    for (int axis = 0; axis < 3; ++axis)
        push_[axis] = towards(push_[axis], std::clamp(wanted[axis], -1.0, 1.0), seconds / soft_start_s);
    // Forward is where the head looks, on the level.
    const glm::dquat turn = glm::angleAxis(yaw_rad_, glm::dvec3(0, 1, 0));
    offset_m_ += seconds * move_m_per_s * (turn * push_);
}

void Navigator::centre() {
    *this = {};
}

Pose Navigator::head(const Pose& around) const {
    const glm::dquat turn = glm::angleAxis(yaw_rad_, glm::dvec3(0, 1, 0));
    const glm::dquat tilt = glm::angleAxis(pitch_rad_, glm::dvec3(1, 0, 0));
    return {around.position_m + around.orientation * offset_m_, glm::normalize(around.orientation * turn * tilt)};
}

double head_box_fading(double distance_m, double box_radius_m) {
    const double beyond = distance_m - box_radius_m;
    return std::clamp(beyond / std::max(min_fade_m, fade_radii * box_radius_m), 0.0, 1.0);
}

}  // namespace equistream
