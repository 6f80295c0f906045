#pragma once
/// What a viewer is sent, block by block, and what becomes of what it sends.
#include "rate.h"

#include <client/timing/head_prediction.h>
#include <client/transport/under_way.h>
#include <equistream/elapsed.h>
#include <equistream/send_times.h>
#include <equistream/viewer_message.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>

namespace equistream::serve {

struct Portion {
    std::size_t bytes = 0;            ///< put into the block; 0: none now
    double due_s = 0;                 ///< when the first of them was due
    std::optional<double> again_s{};  ///< when to ask again, as elapsed time; nothing: the viewer will be woken
    bool held = false;                ///< some is due, at due_s, but the line has too much already
    bool ended = false;               ///< there will be no more
    std::string problem{};            ///< not empty: it cannot go on
};

/// Of one viewer. Times are in seconds since it came.
class Feed {
public:
    virtual ~Feed() = default;
    /// What the viewer's line has not acknowledged of what next() gave; before each next().
    virtual void see_line(double /*elapsed_s*/, const Unacknowledged&) {}
    /// Fills `block` with what is due next.
    virtual Portion next(std::span<char> block, double elapsed_s) = 0;
    /// What the viewer has sent, in pieces of any size.
    virtual void hear(std::span<const char>) {}
};

/// A feed says something at least so often: clients give up a server that is silent.
inline constexpr double longest_silence_s = 1;

/// What it says where there is nothing: an element of Matroska without bytes, Void, that readers pass over. It may
/// stand between any two clusters.
inline constexpr std::array<char, 2> void_element = {char(0xec), char(0x80)};
inline Portion nothing(std::span<char> block, double elapsed_s) {
    std::ranges::copy(void_element, block.begin());
    return {.bytes = void_element.size(), .due_s = elapsed_s};
}

/// What all viewers look at.
class Programme {
public:
    virtual ~Programme() = default;
    /// For a viewer that has come. The programme outlives it.
    virtual std::unique_ptr<Feed> open_feed() = 0;
};

/// Where a viewer's head is and will be, from what it sends. Times are by its own clock, from when it came.
class HeardHead {
public:
    /// Whether a pose was completed by these bytes.
    bool hear(std::span<const char> bytes);
    bool is_known() const { return pose_.has_value(); }
    /// One that only looks leaves the path to others.
    bool steers() const { return pose_ && pose_->steers; }
    /// As the viewer said it last. It must be known.
    const Pose& last() const { return pose_->head; }
    /// Where it was last, turned as it will be so long from now. It must be known.
    Pose head(double ahead_s) const;
    /// What the viewer says that it shows, or what most do at most; no wider than any headset.
    ViewExtent view() const;
    /// Since the last pose came. It must be known.
    double age_s() const { return seconds_since(heard_); }

private:
    Clock::time_point start_ = Clock::now();
    ViewerMessageReader messages_;
    std::optional<ViewerPose> pose_;
    Clock::time_point heard_{};  // the pose
    HeadPredictor turning_;
    std::optional<double> seen_s_;  // when the predictor was told a pose last
};

// Recorded streams.

/// Of a stream of tiles (tile_stream.h) each viewer gets those that it looks at. `loop`: over and over. Throws
/// InputError for what cannot be read or is no video with times, and for tiles over and over. `interrupted`: as
/// read_send_times asks it.
std::unique_ptr<Programme> open_recording(const std::string& file, bool loop,
                                          const std::function<bool()>& interrupted = {});

// A stream that is being made, for all who watch: each viewer gets the header and, from the next group of pictures on,
// the same bytes as everybody; who steers is told from what they send. A viewer that falls behind goes on with the next
// group, and misses what lies between; nobody waits for it. One thread: that of the io_context.

class LiveFeed;

class LiveStream : public Programme {
public:
    /// `changed`: a viewer has come or gone, or the pose that steers has changed.
    explicit LiveStream(std::function<void()> changed) : changed_(std::move(changed)) {}

    std::unique_ptr<Feed> open_feed() override;

    /// Before any bytes.
    void set_header(const std::string& header);
    void publish(const std::string& bytes, bool begins_group);
    /// There will be no more.
    void end();

    std::size_t viewers() const { return feeds_.size(); }
    /// Of the viewers whose last pose steers, the one that came first: where its head is, as it said last. Clients know
    /// their own poses again.
    std::optional<Pose> steering() const;
    /// Since that pose came.
    std::optional<double> steering_age_s() const;
    /// So long from now, the mean of a gaze and of the gazes within 30 degrees of it, in the world: the gaze of the
    /// viewer that steers, or while nobody does of the first that has sent a pose. Nothing: no viewer has sent one.
    std::optional<glm::dvec3> gaze(double ahead_s) const;
    std::int64_t poses_heard() const { return poses_heard_; }
    /// Of the viewer that steers, or of the first one while nobody does: its number, from 1, and how it keeps up.
    /// Nothing: there is none.
    std::optional<std::pair<int, Delivery>> delivery() const;
    /// Spheres that viewers missed because they were behind, of all viewers.
    std::int64_t spheres_missed() const { return spheres_missed_; }
    /// Whether somebody has come or fallen behind since this was asked last, for whom a group should begin.
    bool take_group_wanted() { return std::exchange(is_group_wanted_, false); }

private:
    friend class LiveFeed;

    const LiveFeed* steers() const;  // null: nobody does

    std::function<void()> changed_;
    std::list<LiveFeed*> feeds_;  // in the order they came
    std::shared_ptr<const std::string> header_;
    bool is_group_wanted_ = false, ended_ = false;
    int feeds_opened_ = 0;
    std::int64_t poses_heard_ = 0, spheres_missed_ = 0;
};

/// The mean of the first one, which always counts, and of those within 30 degrees of it. There is one at least.
glm::dvec3 mean_gaze(std::span<const glm::dvec3> gazes);

}  // namespace equistream::serve
