#include "feeds.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <algorithm>
#include <filesystem>
#include <map>

namespace equistream {

namespace {

/// A picture is waited for until a later one of its track has come, or so much is held: tracks are interleaved only
/// roughly (a fragmented mp4 through a pipe brings a group of one, then of the other), and one may simply have ended.
constexpr std::size_t most_held_frames = 64;
constexpr std::size_t most_held_bytes = std::size_t{512} << 20;

class StreamFeed : public FrameFeed {
public:
    StreamFeed(const std::string& source, const FeedOptions& options) : reader_(source), options_(options) {
        std::error_code error;
        const auto size = std::filesystem::file_size(source, error);
        file_bytes_ = error ? 0 : double(size);
        for (const StreamTrackSummary& track : reader_.tracks())
            has_small_ |= track.role == TrackRole::small;
    }

    std::optional<ReceivedFrame> next() override {
        for (;;) {
            while (!first_is_settled() && !ended_)
                take(reader_.next());
            if (waiting_.empty())
                return std::nullopt;
            auto first = waiting_.extract(waiting_.begin());
            if (first.mapped().main) {
                last_given_ = first.key();
                return finish(std::move(first.mapped()));
            }
            // The main picture is lost: a small one alone shows nothing.
        }
    }

    std::string truncation() const override { return reader_.truncation(); }
    std::vector<FeedTrack> tracks() const override {
        std::vector<FeedTrack> tracks;
        for (const StreamTrackSummary& track : reader_.tracks())
            tracks.push_back({track_name(track.role), track.pictures, track.bytes});
        return tracks;
    }
    std::optional<double> fraction_done() const override {
        double bytes = 0;
        for (const FeedTrack& track : tracks())
            bytes += double(track.bytes);
        return file_bytes_ > 0 ? std::optional(std::min(1.0, bytes / file_bytes_)) : std::nullopt;
    }

private:
    struct Partial {
        std::optional<ReceivedPicture> main, small;
        bool posed = true;
    };

    /// Both pictures of the first waiting frame are here, or will not come.
    bool first_is_settled() const {
        if (waiting_.empty())
            return false;
        const auto& [index, first] = *waiting_.begin();
        const bool main_is_known = first.main || last_main_ > index;
        const bool small_is_known = first.small || !has_small_ || last_small_ > index;
        return (main_is_known && small_is_known) || holds_too_much();
    }

    bool holds_too_much() const {
        std::size_t bytes = 0;
        for (const auto& [index, partial] : waiting_)
            for (const auto* picture : {&partial.main, &partial.small})
                bytes += *picture ? (*picture)->rgb.samples().size() : 0;
        return waiting_.size() > most_held_frames || bytes > most_held_bytes;
    }

    void take(std::optional<DecodedPicture> decoded) {
        if (!decoded) {
            ended_ = true;
            return;
        }
        const bool posed = decoded->info.has_value();
        if (!posed) {
            // A second track of somebody else's video is no second eye of ours.
            has_small_ = false;
            if (decoded->role != TrackRole::main)
                return;
            decoded->info = foreign_info(*decoded);
        } else if (decoded->role == TrackRole::small && !has_small_) {
            return;  // beside somebody else's main track: it is of another recording
        }
        const std::int64_t index = decoded->info->index;
        std::int64_t& last = decoded->role == TrackRole::main ? last_main_ : last_small_;
        last = std::max(last, index);
        if (index > options_.last_frame) {
            (decoded->role == TrackRole::main ? main_is_past_ : small_is_past_) = true;
            ended_ = main_is_past_ && (small_is_past_ || !has_small_);
        }
        if (index < options_.first_frame || index > options_.last_frame || index <= last_given_)
            return;
        Partial& partial = waiting_[index];
        partial.posed = posed;
        auto& place = decoded->role == TrackRole::main ? partial.main : partial.small;
        place = ReceivedPicture{
            std::move(*decoded->info), std::move(decoded->rgb), {}, decoded->decode_ms, decoded->convert_ms};
    }

    /// Video without our data is taken for a full sphere, its pictures numbered as they come.
    FrameInfo foreign_info(const DecodedPicture& picture) {
        FrameInfo info;
        info.index = foreign_index_++;
        const auto& tracks = reader_.tracks();
        if (!tracks.empty() && tracks.front().frames_per_second > 0)
            info.frames_per_second = tracks.front().frames_per_second;
        info.time_s = double(info.index) / info.frames_per_second;
        info.camera = EquirectCamera{picture.rgb.width(), picture.rgb.height(), {}};
        return info;
    }

    static ReceivedFrame finish(Partial partial) {
        if (!partial.posed)
            partial.small.reset();
        return {std::move(*partial.main), std::move(partial.small), partial.posed, {}};
    }

    StreamReader reader_;
    FeedOptions options_;
    std::map<std::int64_t, Partial> waiting_;
    std::int64_t last_given_ = -1;
    std::int64_t last_main_ = -1;  // pictures of a track come in order: an earlier one that is not here is lost
    std::int64_t last_small_ = -1;
    std::int64_t foreign_index_ = 0;
    double file_bytes_ = 0;
    bool has_small_ = false;
    bool main_is_past_ = false;  // beyond the last frame asked for
    bool small_is_past_ = false;
    bool ended_ = false;
};

}  // namespace

std::unique_ptr<FrameFeed> open_stream_feed(const std::string& source, const FeedOptions& options) {
    return std::make_unique<StreamFeed>(source, options);
}

}  // namespace equistream
