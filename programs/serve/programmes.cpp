#include "programmes.h"

#include <algorithm>
#include <cstring>
#include <deque>
#include <vector>

namespace equistream::serve {

namespace {

/// Of one viewer that does not keep up, whatever --patience says.
constexpr std::size_t max_waiting_bytes = 64 << 20;

/// A viewer whose oldest bytes wait for longer leaves out what waits, and goes on with the next group. It asks for one
/// once its line has room.
constexpr double longest_wait_s = 0.5, longest_behind_s = 4;
/// For one that stays behind.
constexpr double between_groups_s = 1;

/// Of a stream, at once: what is not given yet may still be left out.
constexpr std::size_t max_piece_bytes = 1 << 14;

constexpr double shortest_pose_gap_s = 0.01, longest_pose_gap_s = 0.2;

/// The cosine of 30 degrees.
constexpr double min_agreement = 0.866;

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

    void see_line(double elapsed_s, const Unacknowledged& line) override {
        under_way_.see(elapsed_s, bytes_sent_, line);
        held_for_s_ = under_way_.is_too_much(elapsed_s) ? under_way_.oldest_s(elapsed_s) : 0;
    }

    Portion next(std::span<char> block, double elapsed_s) override {
        if (overrun_)
            return {.problem = "the viewer is too far behind"};
        if (held_for_s_ > 0)
            return {.due_s = waiting_.empty() ? *last_sent_s_ : waiting_.front().due_s,
                    .again_s = elapsed_s + UnderWay::between_looks_s,
                    .held = true};
        if (waiting_.empty() && stands_ == Stands::before_group)
            want_group(elapsed_s);
        if (waiting_.empty())
            return nothing_new(block, elapsed_s);
        last_sent_s_ = elapsed_s;
        Part& first = waiting_.front();
        const std::size_t count = std::min({block.size(), max_piece_bytes, first.bytes->size() - first.sent});
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

    void add(const std::shared_ptr<const std::string>& bytes, bool begins_group) {
        // To send what waits may be quicker than a key frame. The last one may have been a finer one.
        const bool is_more = whole_bytes() > key_bytes_ || behind_s() > longest_behind_s;
        if (behind_s() > longest_wait_s && (begins_group || is_more))
            leave_out_what_waits();
        if (begins_group) {
            stands_ = Stands::within_group;
            key_bytes_ = bytes->size();
        }
        if (stands_ == Stands::within_group)
            keep(bytes);
        else if (stands_ == Stands::before_group)
            ++stream_.spheres_missed_;
    }

    void keep(const std::shared_ptr<const std::string>& bytes) {
        if (overrun_)
            return;
        waiting_bytes_ += bytes->size();
        overrun_ = waiting_bytes_ > max_waiting_bytes;
        if (overrun_)
            waiting_.clear();
        else
            waiting_.push_back({bytes, seconds_since(start_)});
    }

    const HeardHead& head() const { return head_; }
    int number() const { return number_; }
    Delivery delivery() const { return {under_way_.acknowledged(), std::max(behind_s(), held_for_s_)}; }

private:
    struct Part {
        std::shared_ptr<const std::string> bytes;
        double due_s = 0;
        std::size_t sent = 0;
    };
    /// It has left some out and goes on with the next group; or it waits for its first one.
    enum class Stands { before_first_group, within_group, before_group };

    double behind_s() const { return waiting_.empty() ? 0 : seconds_since(start_) - waiting_.front().due_s; }

    /// Of what waits, without what is sent in part.
    std::size_t whole_bytes() const {
        const bool is_begun = !waiting_.empty() && waiting_.front().sent > 0;
        return waiting_bytes_ - (is_begun ? waiting_.front().bytes->size() - waiting_.front().sent : 0);
    }

    /// The header goes all the same, and what is sent in part: it has to end.
    void leave_out_what_waits() {
        const auto goes = [&](const Part& part) { return part.sent == 0 && part.bytes != stream_.header_; };
        for (const Part& part : waiting_)
            if (goes(part)) {
                waiting_bytes_ -= part.bytes->size();
                ++stream_.spheres_missed_;
            }
        std::erase_if(waiting_, goes);
        if (stands_ == Stands::within_group)
            stands_ = Stands::before_group;
    }

    /// No more than one a second: groups take bits from all.
    void want_group(double elapsed_s) {
        if (group_wanted_s_ && elapsed_s - *group_wanted_s_ < between_groups_s)
            return;
        group_wanted_s_ = elapsed_s;
        stream_.is_group_wanted_ = true;
    }

    Portion nothing_new(std::span<char> block, double elapsed_s) {
        if (stream_.ended_ || !last_sent_s_)
            return {.ended = stream_.ended_};
        const double due_s = *last_sent_s_ + longest_silence_s;
        if (elapsed_s < due_s)
            return {.again_s =
                        under_way_.is_anything() ? std::min(due_s, elapsed_s + UnderWay::between_looks_s) : due_s};
        last_sent_s_ = elapsed_s;
        return nothing(block, elapsed_s);
    }

    LiveStream& stream_;
    int number_;
    Clock::time_point start_ = Clock::now();
    std::int64_t bytes_sent_ = 0;
    UnderWay under_way_;
    double held_for_s_ = 0;                 // by what is under way; 0: it is not
    std::optional<double> group_wanted_s_;  // last, for having left something out
    std::optional<double> last_sent_s_;     // nothing: not even the header
    std::deque<Part> waiting_;
    std::size_t waiting_bytes_ = 0, key_bytes_ = 0;  // of the last sphere that began a group
    Stands stands_ = Stands::before_first_group;
    bool overrun_ = false;
    HeardHead head_;
};

std::unique_ptr<Feed> LiveStream::open_feed() {
    auto feed = std::make_unique<LiveFeed>(*this);
    if (header_)
        feed->keep(header_);
    is_group_wanted_ = true;
    changed_();
    return feed;
}

void LiveStream::set_header(const std::string& header) {
    header_ = std::make_shared<const std::string>(header);
    for (LiveFeed* feed : feeds_)
        feed->keep(header_);
}

void LiveStream::publish(const std::string& bytes, bool begins_group) {
    if (bytes.empty())  // an encoder that failed has no end to give
        return;
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
        if (glm::dot(gaze, first) >= min_agreement)
            sum += gaze;
    return glm::normalize(sum);
}

}  // namespace equistream::serve
