#pragma once
/// Frames of a source in time, read and decoded by a thread of their own: the display never waits for one.
#include <equistream_client/receive.h>

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

namespace equistream {

using SharedFrame = std::shared_ptr<const ReceivedFrame>;

class FrameLoader {
public:
    /// Opens the source and waits for its first frame. Throws InputError as open_feed does, and where there is none.
    /// `options` without frames_ahead, first_frame and interrupted.
    FrameLoader(std::string source, FeedOptions options);
    ~FrameLoader();
    FrameLoader(const FrameLoader&) = delete;
    FrameLoader& operator=(const FrameLoader&) = delete;

    /// Of the first frame.
    const FrameInfo& first() const { return first_; }

    /// The newest frame that is due at `time_s` of the source's own time, those before it being dropped; null: none has
    /// come since. Throws what reading threw.
    SharedFrame due(double time_s);
    /// Whether a frame is ready, due or not.
    bool is_ready() const;
    /// The next frame, due or not; null: none is ready.
    SharedFrame next();
    /// Starts again at a frame: what was read ahead is dropped, and the source is opened anew. Where it has no frame
    /// from there on it is at its end.
    void seek(std::int64_t frame);

    /// Whether any two frames that followed each other so far were not neighbours.
    bool has_gaps() const;
    bool at_end() const;             ///< all has been read and taken
    double fraction_done() const;    ///< of what was taken, 0 to 1; 0 where the end is not known
    std::string truncation() const;  ///< FrameFeed's, after the end

private:
    struct Ready {
        SharedFrame frame;
        double fraction_done = 0;
    };

    void run();
    void read(std::unique_lock<std::mutex>& lock);
    void rethrow() const;

    static constexpr std::size_t most_ready = 3;

    std::string source_;
    FeedOptions options_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::unique_ptr<FrameFeed> feed_;
    std::deque<Ready> ready_;
    FrameInfo first_;
    std::int64_t wanted_first_ = 0;
    unsigned seeks_ = 0;           ///< a frame that was read before the last does not count
    unsigned opened_for_ = 0;      ///< of seeks, what feed_ was opened for; the reading thread's own
    std::int64_t last_index_ = 0;  ///< of the frame that was read last
    bool has_gaps_ = false;
    double fraction_done_ = 0;
    std::string truncation_;
    bool ended_ = false, stopping_ = false;
    std::exception_ptr failure_;
    std::thread thread_;
};

}  // namespace equistream
