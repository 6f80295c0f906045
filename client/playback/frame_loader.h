#pragma once
/// Frames of a source, read and decoded by a thread of their own into the ring of a player: the display never waits for
/// one. A recorded source (a folder, a file) is read a few frames ahead and waits to be shown; a live one comes at its
/// server's pace, is read as it comes, and is asked for again when its connection is lost.
#include <client/receive/receive.h>
#include <client/timing/frame_slots.h>

#include <equistream/elapsed.h>

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace equistream {

using SharedFrame = std::shared_ptr<const ReceivedFrame>;

struct LoadedFrame {
    SharedFrame frame;
    double fraction_done = 0;  ///< of the source, 0 to 1; 0 where its end is not known
};

/// Frames whose numbers ascend: from one jump in time to the next.
using FrameReel = FrameRing<LoadedFrame>;

/// How reading stands.
struct LoaderState {
    std::shared_ptr<FrameReel> reel;  ///< another one after each jump, and where a server began anew
    bool ended = false;               ///< all there is is in the reel
    int attempts = 0;                 ///< to reach a server that was lost, so far; 0: it is there
    bool failed = false;              ///< so are all that could be read: rethrow() says why there are no more
};

/// What came since the source was opened.
struct LoaderFigures {
    std::int64_t frames = 0, bytes = 0, reconnections = 0;
};

class FrameLoader {
public:
    /// Opens the source and waits for its first frame, which is in the reel then. Frames of other sizes than they are
    /// tagged with are passed over until then. Throws InputError as open_feed does, and where there is none; WorkError
    /// where none is left. What limits the first frame limits no jump of a recorded source. `options` without
    /// frames_ahead and first_frame; `interrupted` ends this and what is read later. Of a recorded source as
    /// many frames are read ahead as `max_ahead_bytes` hold, and at least three.
    FrameLoader(std::string source, FeedOptions options, std::size_t max_ahead_bytes = std::size_t{512} << 20);
    ~FrameLoader();
    FrameLoader(const FrameLoader&) = delete;
    FrameLoader& operator=(const FrameLoader&) = delete;

    // Any thread.
    /// Of the first frame.
    const FrameInfo& first() const { return first_; }
    bool is_live() const { return is_live_; }
    /// Whether frames can be asked for again: not of a server, nor of a pipe.
    bool can_jump() const { return can_jump_; }
    /// Whether the first frame says where it was seen from.
    bool is_posed() const { return is_posed_; }
    /// Whether a track says that its transfer is this one (FrameFeed::transfers).
    bool has_transfer(const std::string& name) const;
    const FeedSummary& summary() const { return summary_; }
    /// From the first frame to the end of the last; nothing: not known.
    std::optional<double> seconds() const;
    /// On the clock of FrameStamp::arrival_s.
    double now_s() const { return time_s(Clock::now()); }
    double time_s(Clock::time_point at) const { return std::chrono::duration<double>(at - began_).count(); }

    // The displaying thread.
    LoaderState state() const;
    /// So many frames of this reel were shown, or passed over: as many more may be read.
    void passed(const FrameReel& reel, std::size_t frames);
    /// Starts again at a frame, in another reel: the first from this one on. Where all from there on are of `before_s`
    /// or later, the last one before that time; where there is none before it either, the first of all. Where the
    /// source has no frame from there on it is at its end. A live one is connected to anew and comes as its server
    /// sends it. Not of a pipe.
    void seek(std::int64_t frame, std::optional<double> before_s = {});
    LoaderFigures figures() const;
    std::string truncation() const;  ///< FrameFeed's, after the end
    /// Throws what reading threw.
    void rethrow() const;

private:
    /// What seek() was told.
    struct Wanted {
        std::int64_t first = 0;
        std::optional<double> before_s;
    };

    ReceivedFrame first_sound_frame();
    std::shared_ptr<FrameReel> new_reel() const;
    bool is_late() const { return seconds_since(began_) > options_.first_frame_limit_s; }
    void run();
    bool may_read() const;
    void read(std::unique_lock<std::mutex>& lock);
    void go_to(std::int64_t frame);
    std::optional<ReceivedFrame> find(const Wanted& wanted);
    std::optional<ReceivedFrame> find_last_before(const Wanted& wanted);
    bool is_outdated() const;
    void fail(std::unique_lock<std::mutex>& lock);
    void hang_up(std::unique_lock<std::mutex>& lock);
    void wait_to_try_again(std::unique_lock<std::mutex>& lock);
    void deliver(ReceivedFrame frame);
    void count_bytes();

    std::string source_;
    FeedOptions options_;
    Clock::time_point began_ = Clock::now();
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::unique_ptr<FrameFeed> feed_;
    FrameInfo first_;
    bool is_live_ = false, is_posed_ = false, can_jump_ = false;
    std::vector<std::string> transfers_;
    FeedSummary summary_;
    std::size_t max_ahead_ = 0;  ///< of a recorded source; the ring has room for them while it keeps what is shown
    std::shared_ptr<FrameReel> reel_;
    std::optional<ReceivedFrame> following_;  ///< read already, by a search; the reading thread's own
    std::int64_t newest_ = -1;                ///< number in the reel; the reading thread's own
    std::int64_t cut_at_ = -1;                ///< the newest when the source ended last; the reading thread's own
    std::size_t ahead_ = 0;                   ///< of them, not yet passed
    Wanted wanted_;
    unsigned seeks_ = 0;       ///< a frame that was read before the last does not count
    unsigned opened_for_ = 0;  ///< of seeks, what feed_ was opened for; the reading thread's own
    int attempts_ = 0;
    LoaderFigures figures_;
    std::int64_t feed_bytes_ = 0;  ///< of figures_.bytes, what this feed_ gave
    std::string truncation_;
    bool is_open_ = false, ended_ = false, stopping_ = false;
    std::exception_ptr failure_;
    std::thread thread_;
};

}  // namespace equistream
