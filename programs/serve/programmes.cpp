#include "programmes.h"

#include <client/timing/head_prediction.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/viewer_message.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <deque>

namespace equistream::serve {

namespace {

/// Of one viewer that does not keep up, whatever --patience says.
constexpr std::size_t max_waiting_bytes = 64 << 20;

/// An element of Matroska that readers pass over: Void, of no bytes. It may stand between any two clusters.
constexpr std::array<char, 2> nothing = {char(0xec), char(0x80)};
/// After so long without a picture a viewer is sent that, so that it knows the server is there.
constexpr double longest_silence_s = 1;

}  // namespace

class RecordingFeed : public Feed {
public:
    explicit RecordingFeed(const Recording& recording) : recording_(recording), parts_(recording.times_.parts) {}

    Portion next(std::span<char> block, double elapsed_s) override {
        if (position_ == parts_.back().end) {
            if (!recording_.loop_)
                return {.ended = true};
            position_ = 0;
            round_start_s_ += recording_.times_.duration_s;
        }
        const std::int64_t due = due_at(elapsed_s - round_start_s_);
        if (due <= position_)
            return {.again_s = next_due_s()};
        const auto wanted = std::min(std::size_t(due - position_), block.size());
        const ssize_t count = read(block.first(wanted));
        if (count <= 0)
            return {.problem = "the file has become shorter or cannot be read"};
        const double due_s = next_due_s();
        position_ += count;
        return {.bytes = std::size_t(count), .due_s = due_s};
    }

private:
    /// Where the bytes end that are due at this time.
    std::int64_t due_at(double time_s) const {
        const auto later = std::ranges::upper_bound(parts_, time_s, {}, &DueBytes::time_s);
        return later == parts_.begin() ? 0 : std::prev(later)->end;
    }
    double next_due_s() const {
        return round_start_s_ + std::ranges::upper_bound(parts_, position_, {}, &DueBytes::end)->time_s;
    }
    ssize_t read(std::span<char> bytes) const {
        ssize_t count = 0;
        do
            count = pread(recording_.file_, bytes.data(), bytes.size(), position_);
        while (count < 0 && errno == EINTR);
        return count;
    }

    const Recording& recording_;
    const std::vector<DueBytes>& parts_;  // of the recording
    double round_start_s_ = 0;            // of this repetition
    std::int64_t position_ = 0;           // in the recording
};

Recording::Recording(const std::string& file, bool loop) : times_(read_send_times(file)), loop_(loop) {
    if (loop && !times_.is_matroska)
        throw InputError(expected_found(file, "Matroska for --loop, which can be read end to end again and again",
                                        "another container"));
    file_ = open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (file_ < 0)
        throw InputError(expected_found(file, "a file that can be read", std::strerror(errno)));
}

Recording::~Recording() {
    close(file_);
}

std::unique_ptr<Feed> Recording::open_feed() {
    return std::make_unique<RecordingFeed>(*this);
}

class LiveFeed : public Feed {
public:
    explicit LiveFeed(LiveStream& stream) : stream_(stream) { stream_.feeds_.push_back(this); }
    ~LiveFeed() override {
        stream_.feeds_.remove(this);
        stream_.changed_();
    }

    Portion next(std::span<char> block, double elapsed_s) override {
        if (overrun_)
            return {.problem = "it is too far behind"};
        if (waiting_.empty())
            return nothing_new(block, elapsed_s);
        last_sent_s_ = elapsed_s;
        Part& first = waiting_.front();
        const std::size_t count = std::min(block.size(), first.bytes->size() - first.sent);
        std::memcpy(block.data(), first.bytes->data() + first.sent, count);
        const double due_s = first.due_s;
        first.sent += count;
        waiting_bytes_ -= count;
        if (first.sent == first.bytes->size())
            waiting_.pop_front();
        return {.bytes = count, .due_s = due_s};
    }

    void hear(std::span<const char> bytes) override {
        const auto pose = messages_.take({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
        if (!pose)
            return;
        ++stream_.poses_heard_;
        head_ = pose->head;
        // Poses that came in one burst were not that near to each other.
        const double now_s = seconds_since(start_);
        if (!seen_s_ || now_s - *seen_s_ >= shortest_pose_gap_s) {
            turning_.seen(now_s, pose->head);
            seen_s_ = now_s;
        }
        stream_.changed_();
    }

    void add(const std::shared_ptr<const std::string>& bytes) {
        if (bytes->empty() || overrun_)
            return;
        waiting_bytes_ += bytes->size();
        overrun_ = waiting_bytes_ > max_waiting_bytes;
        if (overrun_)
            waiting_.clear();
        else
            waiting_.push_back({bytes, seconds_since(start_)});
    }

    void add(const std::shared_ptr<const std::string>& bytes, bool begins_group) {
        has_joined_ = has_joined_ || begins_group;
        if (has_joined_)
            add(bytes);
    }

    bool has_head() const { return head_.has_value(); }
    /// Where it was last, turned as it will be so long from now.
    Pose head(double ahead_s) const {
        const double now_s = seconds_since(start_);
        if (now_s - *seen_s_ > longest_pose_gap_s)
            return *head_;
        return {head_->position_m, turning_.predict(now_s + ahead_s).orientation};
    }

private:
    struct Part {
        std::shared_ptr<const std::string> bytes;
        double due_s = 0;
        std::size_t sent = 0;
    };

    LiveStream& stream_;
    Portion nothing_new(std::span<char> block, double elapsed_s) {
        if (stream_.ended_ || !last_sent_s_)
            return {.ended = stream_.ended_};
        const double due_s = *last_sent_s_ + longest_silence_s;
        if (elapsed_s < due_s)
            return {.again_s = due_s};
        std::ranges::copy(nothing, block.begin());
        last_sent_s_ = elapsed_s;
        return {.bytes = nothing.size(), .due_s = elapsed_s};
    }

    Clock::time_point start_ = Clock::now();
    std::optional<double> last_sent_s_;  // nothing: not even the header
    std::deque<Part> waiting_;
    std::size_t waiting_bytes_ = 0;
    bool has_joined_ = false, overrun_ = false;
    ViewerMessageReader messages_;
    std::optional<Pose> head_;
    HeadPredictor turning_;
    std::optional<double> seen_s_;  // when it was told a pose last

    static constexpr double shortest_pose_gap_s = 0.01, longest_pose_gap_s = 0.2;
};

std::unique_ptr<Feed> LiveStream::open_feed() {
    auto feed = std::make_unique<LiveFeed>(*this);
    if (header_)
        feed->add(header_);
    joined_ = true;
    changed_();
    return feed;
}

void LiveStream::set_header(const std::string& header) {
    header_ = std::make_shared<const std::string>(header);
    for (LiveFeed* feed : feeds_)
        feed->add(header_);
}

void LiveStream::publish(const std::string& bytes, bool begins_group) {
    const auto shared = std::make_shared<const std::string>(bytes);
    for (LiveFeed* feed : feeds_)
        feed->add(shared, begins_group);
}

void LiveStream::end() {
    ended_ = true;
}

std::optional<Pose> LiveStream::steering(double ahead_s) const {
    const auto steers = std::ranges::find_if(feeds_, [](const LiveFeed* feed) { return feed->has_head(); });
    return steers == feeds_.end() ? std::nullopt : std::optional((*steers)->head(ahead_s));
}

}  // namespace equistream::serve
