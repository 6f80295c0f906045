#pragma once
/// Tells a live server where the head of a path will be when it makes the next frame, so that frames are made for where
/// the head is at their own time. How far ahead that is frames say themselves, by the head that they were made for: the
/// time of the first one with a head less that of the frame at whose coming it was sent. All times are frames' own, the
/// server's clock.
#include <equistream/frame.h>
#include <equistream/viewer_message.h>

#include <cstdint>
#include <deque>
#include <functional>

namespace equistream::play {

/// How well frames followed.
struct SteeringFigures {
    std::int64_t heads_sent = 0;
    std::int64_t frames = 0;  ///< the first ones that were made for a head that was sent
    double late_s = 0;        ///< of these on average: how much earlier on its path than its frame's time a head was
};

class HeadSteering {
public:
    using Path = std::function<Pose(double time_s)>;
    /// Whether it was sent, as PoseSender::send.
    using Send = std::function<bool(const ViewerPose&)>;

    HeadSteering(Path path, Send send) : path_(std::move(path)), send_(std::move(send)) {}

    /// A frame has come, after all that came before.
    void came(const FrameInfo& frame);
    SteeringFigures figures() const;

private:
    struct Sent {
        double came_s, meant_s;  ///< when the frame before it was, and the one that it is for will be
        Pose head;
    };

    Path path_;
    Send send_;
    std::deque<Sent> sent_;  ///< what no frame was made for yet
    double ahead_s_ = 0;
    std::int64_t heads_sent_ = 0, frames_ = 0;
    double late_s_ = 0;  ///< of all of them
};

}  // namespace equistream::play
