#include "pose_sender.h"

#include <equistream/elapsed.h>

#include <utility>

namespace equistream {

constexpr double shortest_interval_s = 1.0 / 30;

bool PoseSender::send(const ViewerPose& pose) {
    const std::lock_guard lock(mutex_);
    const bool is_known = last_ && last_->position_m == pose.head.position_m &&
                          last_->orientation == pose.head.orientation && last_view_ == view_ &&
                          last_steers_ == pose.steers;
    if (!connection_ || is_known || (last_ && seconds_since(last_at_) < shortest_interval_s))
        return false;
    if (!connection_(encode_viewer_pose({pose.time_s, pose.head, view_, pose.steers})))
        return false;
    last_ = pose.head;
    last_view_ = view_;
    last_steers_ = pose.steers;
    last_at_ = Clock::now();
    return true;
}

void PoseSender::look_through(const PerspectiveCamera& view) {
    const std::lock_guard lock(mutex_);
    view_ = extent_of(view);
}

void PoseSender::use(Connection connection) {
    const std::lock_guard lock(mutex_);
    connection_ = std::move(connection);
    last_.reset();
}

}  // namespace equistream
