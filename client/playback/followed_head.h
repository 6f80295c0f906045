#pragma once
/// What the viewer's head is moved around. That is where each frame's own head is, until the server renders from where
/// it was told this head is: then what moved it is in the frames already, and must not be added to them again.
#include <equistream/camera.h>

#include <deque>

namespace equistream {

class FollowedHead {
public:
    /// A frame is shown whose head is this.
    void show(const Pose& frame_head);
    /// This was sent as where the head is.
    void sent(const Pose& head);

    const Pose& around() const { return around_; }
    /// Whether what is shown was rendered for this head.
    bool is_followed() const { return is_followed_; }

private:
    static constexpr std::size_t max_sent = 4096;  // two minutes of them

    Pose around_;
    std::deque<glm::dvec3> sent_m_;  // positions
    bool is_followed_ = false;
};

}  // namespace equistream
