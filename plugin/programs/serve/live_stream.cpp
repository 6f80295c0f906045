#include "live_stream.h"

#include <equistream/elapsed.h>
#include <equistream/viewer_message.h>

#include <algorithm>
#include <cstring>
#include <deque>

namespace equistream::serve {

namespace {

/// Of one viewer that does not keep up, whatever --patience says.
constexpr std::size_t most_waiting_bytes = 64 << 20;

}  // namespace

class LiveFeed : public Feed {
public:
    explicit LiveFeed(LiveStream& stream) : stream_(stream) { stream_.feeds_.push_back(this); }
    ~LiveFeed() override {
        stream_.feeds_.remove(this);
        stream_.changed_();
    }

    Portion next(std::span<char> block, double) override {
        if (overrun_)
            return {.problem = "it is too far behind"};
        if (waiting_.empty())
            return {.ended = stream_.ended_};
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
        overrun_ = waiting_bytes_ > most_waiting_bytes;
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
    Clock::time_point start_ = Clock::now();
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
