#include "programmes.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <vector>

namespace equistream::serve {

namespace {

/// Of one viewer that does not keep up, whatever --patience says.
constexpr std::size_t max_waiting_bytes = 64 << 20;

/// A viewer whose oldest bytes wait for longer goes on with the next group.
constexpr double longest_wait_s = 0.5;

constexpr double shortest_pose_gap_s = 0.01, longest_pose_gap_s = 0.2;

/// The cosine of 30 degrees.
constexpr double least_agreement = 0.866;

}  // namespace

bool HeardHead::hear(std::span<const char> bytes) {
    const auto pose = messages_.take({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!pose)
        return false;
    pose_ = pose;
    heard_ = Clock::now();
    // Poses that came in one burst were not that near to each other.
    const double now_s = seconds_since(start_);
    if (!seen_s_ || now_s - *seen_s_ >= shortest_pose_gap_s) {
        turning_.seen(now_s, pose->head);
        seen_s_ = now_s;
    }
    return true;
}

Pose HeardHead::head(double ahead_s) const {
    const double now_s = seconds_since(start_);
    if (now_s - *seen_s_ > longest_pose_gap_s)
        return pose_->head;
    return {pose_->head.position_m, turning_.predict(now_s + ahead_s).orientation};
}

ViewExtent HeardHead::view() const {
    constexpr ViewExtent usual{1.5, 1.5}, widest{2.2, 2.2};  // 113 and 131 degrees
    const ViewExtent said = pose_ && pose_->view ? *pose_->view : usual;
    return {std::min(said.half_width, widest.half_width), std::min(said.half_height, widest.half_height)};
}

class LiveFeed : public Feed {
public:
    explicit LiveFeed(LiveStream& stream) : stream_(stream), number_(++stream.feeds_opened_) {
        stream_.feeds_.push_back(this);
    }
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
        bytes_sent_ += std::int64_t(count);
        waiting_bytes_ -= count;
        if (first.sent == first.bytes->size())
            waiting_.pop_front();
        return {.bytes = count, .due_s = due_s};
    }

    void hear(std::span<const char> bytes) override {
        if (!head_.hear(bytes))
            return;
        ++stream_.poses_heard_;
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
        if (begins_group && behind_s() > longest_wait_s)
            pass_over_what_waits();
        has_joined_ = has_joined_ || begins_group;
        if (has_joined_)
            add(bytes);
    }

    const HeardHead& head() const { return head_; }
    int number() const { return number_; }
    Delivery delivery() const { return {bytes_sent_, behind_s()}; }

private:
    struct Part {
        std::shared_ptr<const std::string> bytes;
        double due_s = 0;
        std::size_t sent = 0;
    };

    double behind_s() const { return waiting_.empty() ? 0 : seconds_since(start_) - waiting_.front().due_s; }

    /// All but the header, and what is sent in part: it has to end.
    void pass_over_what_waits() {
        const auto goes = [&](const Part& part) { return part.sent == 0 && part.bytes != stream_.header_; };
        for (const Part& part : waiting_)
            if (goes(part)) {
                waiting_bytes_ -= part.bytes->size();
                ++stream_.spheres_missed_;
            }
        std::erase_if(waiting_, goes);
    }

    Portion nothing_new(std::span<char> block, double elapsed_s) {
        if (stream_.ended_ || !last_sent_s_)
            return {.ended = stream_.ended_};
        const double due_s = *last_sent_s_ + longest_silence_s;
        if (elapsed_s < due_s)
            return {.again_s = due_s};
        last_sent_s_ = elapsed_s;
        return nothing(block, elapsed_s);
    }

    LiveStream& stream_;
    int number_;
    Clock::time_point start_ = Clock::now();
    std::int64_t bytes_sent_ = 0;
    std::optional<double> last_sent_s_;  // nothing: not even the header
    std::deque<Part> waiting_;
    std::size_t waiting_bytes_ = 0;
    bool has_joined_ = false, overrun_ = false;
    HeardHead head_;
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

const LiveFeed* LiveStream::steers() const {
    const auto steers = std::ranges::find_if(feeds_, [](const LiveFeed* feed) { return feed->head().steers(); });
    return steers == feeds_.end() ? nullptr : *steers;
}

std::optional<Pose> LiveStream::steering() const {
    const LiveFeed* const feed = steers();
    return feed == nullptr ? std::nullopt : std::optional(feed->head().last());
}

std::optional<double> LiveStream::steering_age_s() const {
    const LiveFeed* const feed = steers();
    return feed == nullptr ? std::nullopt : std::optional(feed->head().age_s());
}

std::optional<std::pair<int, Delivery>> LiveStream::delivery() const {
    if (feeds_.empty())
        return std::nullopt;
    const LiveFeed* const feed = steers() != nullptr ? steers() : feeds_.front();
    return std::pair(feed->number(), feed->delivery());
}

std::optional<glm::dvec3> LiveStream::gaze(double ahead_s) const {
    std::vector<glm::dvec3> gazes;  // each asked for once: a moment later a head may be elsewhere
    const auto add = [&](const LiveFeed* feed) {
        gazes.push_back(feed->head().head(ahead_s).orientation * glm::dvec3(0, 0, -1));
    };
    const LiveFeed* const first = steers();
    if (first != nullptr)
        add(first);
    for (const LiveFeed* feed : feeds_)
        if (feed != first && feed->head().is_known())
            add(feed);
    return gazes.empty() ? std::nullopt : std::optional(mean_gaze(gazes));
}

glm::dvec3 mean_gaze(std::span<const glm::dvec3> gazes) {
    const glm::dvec3 first = gazes.front();
    glm::dvec3 sum = first;
    for (const glm::dvec3& gaze : gazes.subspan(1))
        if (glm::dot(gaze, first) >= least_agreement)
            sum += gaze;
    return glm::normalize(sum);
}

}  // namespace equistream::serve
