#include "programmes.h"
#include "recorded_file.h"

#include <equistream/error.h>
#include <equistream/tile_stream.h>

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

namespace equistream::serve {

namespace {

/// A viewer that is so far behind goes on with the last group of pictures that is due. It misses what lies between.
constexpr double skips_when_behind_s = 2;

/// A recorded stream that is open for all viewers, each of which gets it from its beginning.
class Recording : public Programme {
public:
    Recording(const std::string& file, bool loop, const std::function<bool()>& interrupted)
        : times_(read_send_times(file, interrupted)), loop_(loop), file_(file) {
        if (loop && !times_.is_matroska)
            throw InputError(expected_found(file, "Matroska for --loop (encode --out NAME.mkv)", "another container"));
        if (!times_.is_matroska && file_.index_comes_last())
            throw InputError(
                expected_found(file, "an MP4 whose index comes first (ffmpeg -movflags +faststart)",
                               "one with its index at the end, which viewers cannot read while it arrives"));
        if (loop && !file_.hide_segment_size())
            throw InputError(expected_found(file, "Matroska that begins with its segment, for --loop", "other bytes"));
        find_cuts(interrupted);
    }

    std::unique_ptr<Feed> open_feed() override;

private:
    friend class RecordingFeed;

    /// Readers take no cluster that is cut, and wait for all tracks of a moment.
    void find_cuts(const std::function<bool()>& interrupted) {
        if (times_.moments.empty())
            return;
        const std::vector<std::int64_t> clusters = file_.clusters(interrupted);
        for (Moment moment : times_.moments) {
            const auto later = std::ranges::upper_bound(clusters, moment.start);
            const std::int64_t begin = later == clusters.begin() ? -1 : *std::prev(later);
            if (begin <= moment.after)
                continue;
            moment.start = begin;
            cuts_.push_back(moment);
        }
    }

    SendTimes times_;
    std::vector<Moment> cuts_;  ///< those that begin a cluster, and where that begins
    bool loop_;
    RecordedFile file_;
};

class RecordingFeed : public Feed {
public:
    explicit RecordingFeed(const Recording& recording) : recording_(recording), parts_(recording.times_.parts) {}

    Portion next(std::span<char> block, double elapsed_s) override {
        if (position_ == parts_.back().end) {
            if (!recording_.loop_)
                return {.ended = true};
            begin_round(elapsed_s);
        }
        const bool is_behind = elapsed_s - next_due_s() > skips_when_behind_s;
        if (is_behind)
            skip_to_group(elapsed_s - round_start_s_);
        std::int64_t due = due_at(elapsed_s - round_start_s_);
        if (due <= position_ && elapsed_s < last_sent_s_ + longest_silence_s)
            return {.again_s = std::min(next_due_s(), last_sent_s_ + longest_silence_s)};
        due = std::max(due, position_ + 1);  // one byte early says that the server is there
        const std::int64_t end = is_behind ? std::min(due, next_cut()) : due;
        const auto wanted = std::min(std::size_t(end - position_), block.size());
        const std::size_t count = recording_.file_.read(position_, block.first(wanted));
        if (count == 0)
            return {.problem = "the file has become shorter or cannot be read"};
        const double due_s = std::min(next_due_s(), elapsed_s);
        position_ += std::int64_t(count);
        last_sent_s_ = elapsed_s;
        return {.bytes = count, .due_s = due_s};
    }

private:
    /// The next one, or the one that is due where the viewer is behind.
    void begin_round(double elapsed_s) {
        const double duration_s = recording_.times_.duration_s;
        position_ = 0;
        round_start_s_ += duration_s;
        if (const double behind_s = elapsed_s - round_start_s_; behind_s > skips_when_behind_s)
            round_start_s_ += duration_s * std::floor(behind_s / duration_s);
    }
    void skip_to_group(double time_s) {
        if (!std::ranges::binary_search(recording_.cuts_, position_, {}, &Moment::start))
            return;
        const Moment* const group = newest_group(recording_.cuts_, time_s);
        if (group == nullptr || group->start <= position_)
            return;
        position_ = group->start;
        skipped_to_s_ = round_start_s_ + group->time_s;
    }
    /// Or the file's end.
    std::int64_t next_cut() const {
        const auto next = std::ranges::upper_bound(recording_.cuts_, position_, {}, &Moment::start);
        return next == recording_.cuts_.end() ? parts_.back().end : next->start;
    }
    /// Where the bytes end that are due at this time.
    std::int64_t due_at(double time_s) const {
        const auto later = std::ranges::upper_bound(parts_, time_s, {}, &DueBytes::time_s);
        return later == parts_.begin() ? 0 : std::prev(later)->end;
    }
    /// A cluster's head is due with what comes before it; where that was left out, with the cluster.
    double next_due_s() const {
        const double in_file_s = std::ranges::upper_bound(parts_, position_, {}, &DueBytes::end)->time_s;
        return std::max(round_start_s_ + in_file_s, skipped_to_s_);
    }

    const Recording& recording_;
    const std::vector<DueBytes>& parts_;  // of the recording
    double round_start_s_ = 0;            // of this repetition
    double skipped_to_s_ = 0;
    double last_sent_s_ = 0;
    std::int64_t position_ = 0;  // in the recording
};

std::unique_ptr<Feed> Recording::open_feed() {
    return std::make_unique<RecordingFeed>(*this);
}

/// Around what a viewer shows: what a head turns to while its pose is on the way, and a margin.
constexpr double guard_rad = 5 * pi / 180, foretold_s = 0.15;
/// A tile is sent for so long after it was looked at last.
constexpr double tile_stays_s = 0.5;
/// A viewer that is so far behind gets the base alone, until it is level again.
constexpr double behind_is_too_much_s = 0.25;

class TileFeed : public Feed {
public:
    explicit TileFeed(const TileRecording& recording) : recording_(recording), sender_(recording) {}

    Portion next(std::span<char> block, double elapsed_s) override {
        while (sent_ == bytes_.size()) {
            const std::optional<double> due_s = sender_.due_s();
            if (!due_s)
                return {.ended = true};
            if (*due_s > elapsed_s)
                return nothing_due(block, elapsed_s, *due_s);
            bytes_.clear();
            sent_ = 0;
            due_s_ = *due_s;
            try {
                if (elapsed_s - due_s_ > skips_when_behind_s) {
                    sender_.skip_to_group(elapsed_s);
                    due_s_ = sender_.due_s().value_or(elapsed_s);
                }
                const bool is_behind = elapsed_s - due_s_ > behind_is_too_much_s;
                sender_.next(is_behind ? std::set<int>() : looked_at(elapsed_s), bytes_);
            } catch (const std::exception& error) {
                return {.problem = error.what()};
            }
        }
        const std::size_t count = std::min(block.size(), bytes_.size() - sent_);
        std::memcpy(block.data(), bytes_.data() + sent_, count);
        sent_ += count;
        last_sent_s_ = elapsed_s;
        return {.bytes = count, .due_s = due_s_};
    }

    void hear(std::span<const char> bytes) override { head_.hear(bytes); }

private:
    Portion nothing_due(std::span<char> block, double elapsed_s, double due_s) {
        const double silent_until_s = last_sent_s_ + longest_silence_s;
        if (elapsed_s < silent_until_s)
            return {.again_s = std::min(due_s, silent_until_s)};
        last_sent_s_ = elapsed_s;
        return nothing(block, elapsed_s);
    }

    /// Until the viewer says where its head is, the recording's own.
    std::set<int> looked_at(double elapsed_s) {
        std::set<int> seen;
        for (const double ahead_s : {0.0, foretold_s}) {
            const Pose head = head_.is_known() ? head_.head(ahead_s) : recording_.first.head;
            const glm::dquat sphere_from_view =
                glm::conjugate(recording_.first.camera_pose.orientation) * head.orientation;
            add_tiles_seen(recording_.grid, sphere_from_view, widened(head_.view(), guard_rad), seen);
        }
        for (const int tile : seen)
            seen_s_[tile] = elapsed_s;
        for (const auto& [tile, at_s] : seen_s_)
            if (elapsed_s - at_s < tile_stays_s)
                seen.insert(tile);
        return seen;
    }

    const TileRecording& recording_;
    TileSender sender_;
    HeardHead head_;
    std::map<int, double> seen_s_;  // tiles, and when they were looked at last
    std::string bytes_;             // of one moment
    std::size_t sent_ = 0;          // of these
    double due_s_ = 0;              // when they were due
    double last_sent_s_ = 0;
};

/// Tells a file from one that has replaced it.
struct Identity {
    dev_t device;
    ino_t file;
    off_t bytes;
    std::int64_t written_ns;
    bool operator==(const Identity&) const = default;
};

Identity identity_of(const std::string& file) {
    struct stat found {};
    if (::stat(file.c_str(), &found) != 0)
        throw WorkError(file + ": " + std::strerror(errno));
    return {found.st_dev, found.st_ino, found.st_size,
            found.st_mtim.tv_sec * std::int64_t(1'000'000'000) + found.st_mtim.tv_nsec};
}

/// A recorded stream of tiles: each viewer gets the tiles that it looks at.
class TiledRecording : public Programme {
public:
    explicit TiledRecording(TileRecording recording) : recording_(std::move(recording)) {}

    std::unique_ptr<Feed> open_feed() override {
        auto feed = std::make_unique<TileFeed>(recording_);
        if (identity_of(recording_.file) != identity_)  // its bytes are due at other times
            throw WorkError(expected_found(recording_.file, "the same file as when the server started",
                                           "a changed one; restart serve"));
        return feed;
    }

private:
    TileRecording recording_;
    Identity identity_ = identity_of(recording_.file);
};

}  // namespace

std::unique_ptr<Programme> open_recording(const std::string& file, bool loop,
                                          const std::function<bool()>& interrupted) {
    std::optional<TileRecording> tiles = open_tiles(file, interrupted);
    if (!tiles)
        return std::make_unique<Recording>(file, loop, interrupted);
    if (loop)
        throw InputError(expected_found("--loop: " + file, "a stream without tiles", "one with tiles"));
    return std::make_unique<TiledRecording>(std::move(*tiles));
}

}  // namespace equistream::serve
