#include "live_stream.h"

#include <equistream/elapsed.h>
#include <equistream/viewer_message.h>

#include <algorithm>
#include <array>
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

    const std::optional<Pose>& head() const { return head_; }

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

std::optional<Pose> LiveStream::steering() const {
    const auto steers = std::ranges::find_if(feeds_, [](const LiveFeed* feed) { return feed->head().has_value(); });
    return steers == feeds_.end() ? std::nullopt : (*steers)->head();
}

}  // namespace equistream::serve
