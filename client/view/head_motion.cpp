#include "head_motion.h"

#include <equistream/conventions.h>
#include <equistream/text.h>

#include <client/warp/engine.h>

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

/// As long as a pose counts for the predictor.
constexpr double resting_s = 0.18;
/// Keys held through a pause of the whole program turn no further.
constexpr double longest_step_s = 0.25;
/// Of what a refresh adds to the average.
constexpr double newest_share = 0.1;

void DisplayLatency::measured(double seconds) {
    seconds_ = known_ ? seconds_ + newest_share * (seconds - seconds_) : seconds;
    known_ = true;
}

void HeadMotion::steer(const Steering& steering, double time_s) {
    const Pose before = head();
    if (!time_s_)
        moved_s_ = time_s - 2 * resting_s;
    navigator_.steer(steering, std::clamp(time_s - time_s_.value_or(time_s), 0.0, longest_step_s));
    time_s_ = time_s;
    if (!same_pose(before, head()))
        moved_s_ = time_s;
    predictor_.seen(time_s, head());
}

void HeadMotion::centre() {
    navigator_.centre();
    predictor_ = {};
    if (time_s_)
        predictor_.seen(*time_s_, head());
}

Pose HeadMotion::predict(double ahead_s) const {
    return is_resting() || ahead_s <= 0 ? head() : predictor_.predict(*time_s_ + ahead_s);
}

bool HeadMotion::is_resting() const {
    return !time_s_ || *time_s_ - moved_s_ > resting_s;
}

std::string in_words(const Pose& head) {
    const glm::dvec3 ahead = head.orientation * glm::dvec3(0, 0, -1), right = head.orientation * glm::dvec3(1, 0, 0);
    const auto degrees = [](double rad) { return std::round(rad * 180 / pi) + 0.0; };
    const auto cm = [](double m) { return std::round(100 * m) + 0.0; };  // no "-0"
    const glm::dvec3& at_m = head.position_m;
    // By what is to its right, which says where ahead is of one that looks straight up too.
    return formatted("yaw %.0f pitch %.0f deg, head %.0f %.0f %.0f cm", degrees(std::atan2(-right.z, right.x)),
                     degrees(std::asin(std::clamp(ahead.y, -1.0, 1.0))), cm(at_m.x), cm(at_m.y), cm(at_m.z));
}

}  // namespace equistream
