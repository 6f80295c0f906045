#include "followed_head.h"

#include <algorithm>

namespace equistream {

namespace {

/// Positions travel unchanged.
constexpr double same_place_m = 1e-9;

}  // namespace

void FollowedHead::show(const Pose& frame_head) {
    is_followed_ = std::ranges::any_of(sent_m_, [&](const glm::dvec3& position_m) {
        return glm::distance(position_m, frame_head.position_m) <= same_place_m;
    });
    if (!is_followed_)
        around_ = frame_head;
}

void FollowedHead::sent(const Pose& head) {
    sent_m_.push_back(head.position_m);
    if (sent_m_.size() > max_sent)
        sent_m_.pop_front();
}

}  // namespace equistream
