#pragma once
/// Which frame a viewer shows when: from the ring that a FrameLoader fills, by a MediaClock. No wall clock: callers say
/// what time it is, on FrameLoader::now_s(). One thread.
///
/// A live source is shown behind the play-out delay that the clock chooses, with all that the clock does while frames
/// are late, do not come, or come again; pausing stops the picture and not the stream, and who plays on is where the
/// stream is by then. Frames of a recorded source are handed to the same clock as if each had come exactly when it was
/// due, on a time that stands still while it is paused and while reading does not keep up, so that nothing is rushed
/// after that.
#include "frame_loader.h"

#include <equistream/camera.h>

#include <client/timing/media_clock.h>

#include <deque>
#include <optional>
#include <vector>

namespace equistream {

/// Of a source, since it was opened.
struct PlaybackCounts {
    std::int64_t late = 0;     ///< frames that came after the time at which they were to be shown
    std::int64_t lost = 0;     ///< frames that were sent and did not come, so far; of posed frames and live sources
    std::int64_t skipped = 0;  ///< frames that came and were passed over
};

class Playback {
public:
    struct Moment {
        SharedFrame frame;     ///< to be shown from now on; null: the one before stays
        bool is_over = false;  ///< the last frame was shown for its time, or there is none; once
    };

    /// A paused one shows the first frame.
    explicit Playback(FrameLoader& loader, bool paused = false);

    /// At a refresh; these ascend. The first has the first frame. Once all that could be read was shown, throws what
    /// reading the next threw, and is paused.
    Moment refresh(double now_s);
    /// Recorded sources: until the next refresh no time passes.
    void hold() { is_held_ = true; }

    void pause() { paused_ = true; }
    /// From the beginning where it is over; a server is asked anew. A pipe stays over.
    void play();
    bool is_paused() const { return paused_; }
    /// Recorded sources: the next frame is shown as soon as it is there, paused or not.
    void step() { stepping_ = true; }
    /// Whether there are jumps in time: not in what comes live, nor in a pipe.
    bool can_jump() const { return loader_.can_jump(); }
    /// Where there are jumps: from the first frame at `time_s` on.
    void seek(double time_s);
    /// The same, but from the last frame before the one that was shown last where that would be no earlier one. Frame
    /// numbers may have gaps.
    void seek_back(double time_s);
    /// So much later than `from_s`, and no later than leads to the last frame of a source of so many `seconds`; 0: not
    /// known.
    double time_on_s(double from_s, double by_s, double seconds) const;

    bool is_live() const { return loader_.is_live(); }
    double time_s() const { return time_s_; }  ///< of the source
    /// By how much what moves by itself is to be shown later than in the frame (extrapolate.h) where that is seen so
    /// long after the last refresh: at time_s(), and of a live source by up to `max_ahead_s` more, as if frames came as
    /// soon as the path lets them. Goes on without a step, for what the path takes is followed slowly.
    double extrapolation_s(double max_ahead_s, double until_seen_s = 0) const;
    /// Frame time of the last frame that was given; nothing: none was since a jump.
    std::optional<double> shown_s() const { return shown_number_ < 0 ? std::nullopt : std::optional(shown_s_); }
    double fraction_done() const { return fraction_done_; }
    ClockState state() const { return state_; }
    /// Of a live source: for how long the next frame has been overdue; 0: it is not.
    double overdue_s() const;
    /// To reach a server that was lost; 0: it is there.
    int attempts() const { return attempts_; }
    double playout_delay_s() const { return clock_.playout_delay_s(); }
    /// Of a live source: by how much the times between arrivals differ from those between frames, as RFC 3550 (6.4.1)
    /// averages it.
    double jitter_s() const { return jitter_s_; }
    PlaybackCounts counts() const { return counts_; }
    /// Whether a later refresh may have something new although nothing is done here.
    bool is_moving() const { return !paused_ || stepping_; }

private:
    void take_arrivals();
    std::int64_t number_at(double time_s) const;
    void jump(double time_s, std::int64_t number, std::optional<double> before_s);
    void count(const FrameStamp& stamp);
    void begin_at_next();
    Moment refresh_live(bool ended, double elapsed_s);
    Moment refresh_recorded(bool ended, double elapsed_s);
    Moment show(double frame_time_s);
    Moment finish();
    void forget_reel();
    double interval_s() const;

    FrameLoader& loader_;
    std::shared_ptr<FrameReel> reel_;
    MediaClock clock_;
    bool paused_, stepping_ = true, over_ = false;
    bool clock_runs_ = false;  ///< a frame of this reel has come
    std::optional<double> now_s_;
    bool is_held_ = false;
    double base_s_ = 0;                ///< of a recorded source: what the clock is told; stands still at times
    double shown_since_s_ = 0;         ///< on base_s_: what is shown came on show
    bool has_ended_ = false;           ///< there will be no more frames
    double due_s_ = 0;                 ///< on base_s_: frames are due so long after their own time
    std::vector<FrameStamp> waiting_;  ///< of a recorded source: came, and not passed
    std::int64_t shown_number_ = -1;
    double shown_s_ = 0, newest_s_ = 0;     ///< frame times
    std::optional<FrameStamp> last_shown_;  ///< before and after jumps
    double newest_arrival_s_ = 0;
    std::optional<double> path_delay_s_;  ///< of a live source: the clock's, followed
    double behind_s_ = 0;                 ///< of a live source: what that lets come less what is shown
    double time_s_ = 0, fraction_done_ = 0;
    ClockState state_ = ClockState::starting;
    int attempts_ = 0;
    std::optional<FrameStamp> last_arrival_;  ///< of the reel
    double jitter_s_ = 0;
    std::vector<std::int64_t> came_;  ///< numbers of frames in the reel that are neither shown nor passed over
    PlaybackCounts counts_;
};

// What the viewer's head is moved around. That is where each frame's own head is, until the server renders from where
// it was told this head is: then what moved it is in the frames already, and must not be added to them again.

class FollowedHead {
public:
    /// A frame is shown whose head is this.
    void show(const Pose& frame_head);
    /// This was sent as where the head is.
    void sent(const Pose& head);
    /// This was sent as where the head looks alone. Servers from before there were such poses render from it all the
    /// same; such a frame moves nothing either.
    void looked(const Pose& head);

    const Pose& around() const { return around_; }
    /// Whether what is shown was rendered for this head.
    bool is_followed() const { return is_followed_; }

private:
    static constexpr std::size_t max_sent = 4096;  // two minutes of them
    static void keep(std::deque<Pose>& heads, const Pose& head);

    Pose around_;
    std::deque<Pose> sent_, looked_;
    bool is_followed_ = false;
};

// Poses in the axes of another pose.

/// A pose in the axes of `outer`, in the axes that `outer` is in.
inline Pose composed(const Pose& outer, const Pose& inner) {
    return {outer.position_m + outer.orientation * inner.position_m,
            glm::normalize(outer.orientation * inner.orientation)};
}

}  // namespace equistream
