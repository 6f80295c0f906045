#include "head_motion.h"

#include <equistream_client/engine.h>

#include <algorithm>

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

Pose composed(const Pose& outer, const Pose& inner) {
    return {outer.position_m + outer.orientation * inner.position_m,
            glm::normalize(outer.orientation * inner.orientation)};
}

}  // namespace equistream
