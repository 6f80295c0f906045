#include "feeds.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <client/transport/address.h>
#include <client/warp/engine.h>

#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <stop_token>
#include <thread>
#include <utility>

namespace equistream {

void require_patches_of_main(const std::string& source, const ReceivedFrame& frame) {
    if (!frame.patches || !frame.patches->info.patches)
        return;
    const Camera sphere = frame.patches->info.patches->sphere();
    const ReceivedPicture& main = frame.main;
    const bool same_size = main.width() == width_of(sphere) && main.height() == height_of(sphere);
    if (same_size && same_camera(sphere, main.info.camera))
        return;
    throw WorkError(expected_found(source + ": frame " + std::to_string(main.info.index) + " of patches",
                                   "the sphere of its main picture, " + size_text(main.width(), main.height()),
                                   same_size ? "another range" : size_text(width_of(sphere), height_of(sphere))));
}

void look_through_window(const std::string& source, ReceivedPicture window, ReceivedFrame& frame) {
    const FrameInfo& base = frame.main.info;
    const std::string where = source + ": frame " + std::to_string(base.index) + " of window";
    if (!std::holds_alternative<EquirectCamera>(window.info.camera) ||
        !std::holds_alternative<EquirectCamera>(base.camera))
        throw WorkError(expected_found(where, "a part of a sphere, and a sphere around it", "a flat view"));
    if (!same_pose(window.info.camera_pose, base.camera_pose))
        throw WorkError(expected_found(where, "the position and the axes of the sphere around it", "others"));
    frame.base = std::exchange(frame.main, std::move(window));
}

namespace {

/// A feed that a thread of its own reads while frames before are worked on. Whoever asks sees what the feed said when
/// it gave the frame, not what it says by now.
class ReadAhead : public FrameFeed {
public:
    ReadAhead(const std::string& source, const FeedOptions& options)
        : most_(options.frames_ahead), feed_(open(source, options)), given_(state()), thread_([this] { read(); }) {}
    ~ReadAhead() override {
        stop_.request_stop();
        thread_.join();
    }

    std::optional<ReceivedFrame> next() override {
        std::unique_lock lock(mutex_);
        arrived_.wait(lock, [&] { return !arrivals_.empty(); });
        Arrival& first = arrivals_.front();
        if (first.problem)
            std::rethrow_exception(first.problem);
        given_ = first.state;
        if (!first.frame)
            return std::nullopt;
        std::optional<ReceivedFrame> frame = std::move(first.frame);
        arrivals_.pop_front();
        room_.notify_all();
        return frame;
    }
    std::string truncation() const override { return given_.truncation; }
    std::vector<FeedTrack> tracks() const override { return given_.tracks; }
    std::optional<double> fraction_done() const override { return given_.fraction_done; }
    bool is_live() const override { return feed_->is_live(); }
    std::vector<std::string> transfers() const override { return given_.transfers; }
    FeedSummary summary() const override { return given_.summary; }
    bool seek(std::int64_t) override { return false; }

private:
    struct State {
        std::string truncation;
        std::vector<FeedTrack> tracks;
        std::optional<double> fraction_done;
        std::vector<std::string> transfers;
        FeedSummary summary;
    };
    /// A frame, or the end, or what went wrong; the last two stay.
    struct Arrival {
        std::optional<ReceivedFrame> frame;
        std::exception_ptr problem;
        State state;
    };

    std::unique_ptr<FrameFeed> open(const std::string& source, FeedOptions options) {
        options.frames_ahead = 0;
        // A source that is slow to give must not hold up the end.
        options.interrupted = [this, asked = std::move(options.interrupted)] {
            return stop_.stop_requested() || (asked && asked());
        };
        return open_feed(source, options);
    }

    /// The reading thread's, once there is one.
    State state() const {
        return {feed_->truncation(), feed_->tracks(), feed_->fraction_done(), feed_->transfers(), feed_->summary()};
    }

    void read() {
        for (bool more = true; more;) {
            Arrival arrival;
            try {
                arrival.frame = feed_->next();
                arrival.state = state();
            } catch (...) {
                arrival.problem = std::current_exception();
            }
            more = arrival.frame.has_value();
            std::unique_lock lock(mutex_);
            room_.wait(lock, stop_.get_token(), [&] { return arrivals_.size() < most_; });
            if (stop_.stop_requested())
                return;
            arrivals_.push_back(std::move(arrival));
            arrived_.notify_all();
        }
    }

    const std::size_t most_;
    std::stop_source stop_;
    std::unique_ptr<FrameFeed> feed_;
    State given_;
    std::mutex mutex_;
    std::condition_variable arrived_;
    std::condition_variable_any room_;
    std::deque<Arrival> arrivals_;
    std::thread thread_;  // last: it begins when all else is there
};

/// A stream that is given up unless its first frame comes in time.
class PromptFeed : public FrameFeed {
public:
    PromptFeed(const std::string& source, const FeedOptions& options)
        : source_(without_secrets(source)), limit_s_(options.first_frame_limit_s),
          feed_(in_time([&] { return open(source, options); })) {}

    std::optional<ReceivedFrame> next() override {
        std::optional<ReceivedFrame> frame = in_time([&] { return feed_->next(); });
        if (!frame)
            require_in_time();
        has_given_ = true;
        return frame;
    }
    std::string truncation() const override { return feed_->truncation(); }
    std::vector<FeedTrack> tracks() const override { return feed_->tracks(); }
    std::optional<double> fraction_done() const override { return feed_->fraction_done(); }
    bool is_live() const override { return feed_->is_live(); }
    std::vector<std::string> transfers() const override { return feed_->transfers(); }
    FeedSummary summary() const override { return feed_->summary(); }
    bool seek(std::int64_t frame) override { return feed_->seek(frame); }

private:
    std::unique_ptr<FrameFeed> open(const std::string& source, FeedOptions options) {
        options.interrupted = [this, asked = std::move(options.interrupted)] {
            return is_late() || (asked && asked());
        };
        return open_stream_feed(source, options);
    }

    bool is_late() const { return !has_given_ && seconds_since(began_) > limit_s_; }
    void require_in_time() const {
        if (is_late())
            throw WorkError(formatted("%s: no frame came within %g s", source_.c_str(), limit_s_));
    }
    /// What was ended for being late fails in words of its own.
    template <typename Work>
    auto in_time(Work work) const -> decltype(work()) {
        try {
            return work();
        } catch (const std::exception&) {
            require_in_time();
            throw;
        }
    }

    const std::string source_;
    const double limit_s_;
    const Clock::time_point began_ = Clock::now();
    bool has_given_ = false;
    std::unique_ptr<FrameFeed> feed_;
};

}  // namespace

std::unique_ptr<FrameFeed> open_feed(const std::string& source, const FeedOptions& options) {
    if (options.frames_ahead > 0)
        return std::make_unique<ReadAhead>(source, options);
    std::error_code ignored;
    if (std::filesystem::is_directory(source, ignored)) {
        if (options.hdr_display)
            throw InputError(expected_found(source, "an HDR stream, as HDR options are given",
                                            "a folder of frames; leave these out"));
        return open_folder_feed(source, options);
    }
    if (std::isfinite(options.first_frame_limit_s))
        return std::make_unique<PromptFeed>(source, options);
    return open_stream_feed(source, options);
}

}  // namespace equistream
