#include "head_motion.h"

#include <client/warp/engine.h>
#include <equistream/formatted.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

/// As long as a pose counts for the predictor.
constexpr double resting_s = 0.18;
/// Keys held through a pause of the whole program turn no further.
constexpr double longest_step_s = 0.25;
/// Of what a refresh adds to the average.
constexpr double newest_share = 0.1;

}  // namespace

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
