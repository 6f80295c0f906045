#include "head_steering.h"

#include <algorithm>
#include <cmath>

namespace equistream::play {

namespace {

/// A server that never makes a frame for what it is sent, as of a recorded stream.
constexpr std::size_t max_sent = 256;

/// Numbers travel unchanged.
bool same_head(const Pose& a, const Pose& b) {
    return glm::distance(a.position_m, b.position_m) <= 1e-9 &&
           std::abs(glm::dot(a.orientation, b.orientation)) > 1 - 1e-12;
}

}  // namespace

void HeadSteering::came(const FrameInfo& frame) {
    const auto made_for =
        std::ranges::find_if(sent_, [&](const Sent& sent) { return same_head(sent.head, frame.head); });
    if (made_for != sent_.end()) {
        ahead_s_ = frame.time_s - made_for->came_s;
        late_s_ += frame.time_s - made_for->meant_s;
        ++frames_;
        sent_.erase(sent_.begin(), made_for + 1);
    }
    const double meant_s = frame.time_s + ahead_s_;
    const Pose head = path_(meant_s);
    if (!send_({frame.time_s, head}))
        return;
    ++heads_sent_;
    sent_.push_back({frame.time_s, meant_s, head});
    if (sent_.size() > max_sent)
        sent_.pop_front();
}

SteeringFigures HeadSteering::figures() const {
    return {heads_sent_, frames_, late_s_ / double(std::max<std::int64_t>(1, frames_))};
}

}  // namespace equistream::play
