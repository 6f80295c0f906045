#include "feeds.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>
#include <vector>

namespace equistream {

namespace {

/// A picture is waited for until a later one of its track has come, or so much is held: tracks are interleaved only
/// roughly (a fragmented mp4 through a pipe brings a group of one, then of the other), and one may simply have ended.
constexpr std::size_t most_held_frames = 64;
constexpr std::size_t most_held_bytes = std::size_t{512} << 20;

/// A track is somebody else's if its first pictures carry no frame data; a single one of ours may have lost it.
constexpr int pictures_to_judge_by = 4;

class StreamFeed : public FrameFeed {
public:
    StreamFeed(const std::string& source, const FeedOptions& options)
        : reader_(source, {.rgb = true, .interrupted = options.interrupted}), options_(options) {
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
            tracks.push_back(given_of(track.role));
        return tracks;
    }
    std::optional<double> fraction_done() const override {
        double bytes = 0;
        for (const StreamTrackSummary& track : reader_.tracks())
            bytes += double(track.bytes);
        return file_bytes_ > 0 ? std::optional(std::min(1.0, bytes / file_bytes_)) : std::nullopt;
    }

private:
    struct Partial {
        std::optional<ReceivedPicture> main, small;
        std::int64_t main_bytes = 0, small_bytes = 0;
        bool posed = true;
    };

    enum class Origin { unknown, ours, foreign };
    struct Track {
        Origin origin = Origin::unknown;
        int without_data = 0;    // pictures, while the origin is unknown
        std::int64_t last = -1;  // pictures of a track come in order: an earlier one that is not here is lost
        bool is_past = false;    // beyond the last frame asked for

        void judge_by(const DecodedPicture& picture) {
            if (origin == Origin::unknown && picture.info)
                origin = Origin::ours;
            else if (origin == Origin::unknown && ++without_data == pictures_to_judge_by)
                origin = Origin::foreign;
        }
    };

    FeedTrack given_of(TrackRole role) const {
        const bool is_main = role == TrackRole::main;
        return {track_name(role), is_main ? given_main_.pictures : given_small_.pictures,
                is_main ? given_main_.bytes : given_small_.bytes};
    }

    bool expects_small() const { return has_small_ && small_.origin != Origin::foreign; }

    /// Both pictures of the first waiting frame are here, or will not come.
    bool first_is_settled() const {
        if (waiting_.empty())
            return false;
        const auto& [index, first] = *waiting_.begin();
        const bool main_is_known = first.main || main_.last > index;
        const bool small_is_known = first.small || !expects_small() || small_.last > index;
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
            if (main_.origin == Origin::unknown)
                take_for_foreign();
            return;
        }
        const bool is_main = decoded->role == TrackRole::main;
        Track& track = is_main ? main_ : small_;
        track.judge_by(*decoded);
        if (is_main && track.origin != Origin::ours) {
            unjudged_.push_back(std::move(*decoded));
            if (track.origin == Origin::foreign)
                take_for_foreign();
            return;
        }
        if (is_main)
            unjudged_.clear();
        // Without its data a picture of ours is damaged; a second track of somebody else's video is no second eye, nor
        // is our small one beside a main track that is not.
        if (decoded->info && track.origin == Origin::ours && main_.origin != Origin::foreign)
            keep(std::move(*decoded), true);
    }

    void take_for_foreign() {
        main_.origin = Origin::foreign;
        small_.origin = Origin::foreign;
        for (DecodedPicture& picture : std::exchange(unjudged_, {})) {
            picture.info = foreign_info(picture);
            keep(std::move(picture), false);
        }
    }

    /// `picture` has its info.
    void keep(DecodedPicture picture, bool posed) {
        const bool is_main = picture.role == TrackRole::main;
        Track& track = is_main ? main_ : small_;
        const std::int64_t index = picture.info->index;
        track.last = std::max(track.last, index);
        if (index > options_.last_frame) {
            track.is_past = true;
            ended_ = main_.is_past && (small_.is_past || !expects_small());
        }
        if (index < options_.first_frame || index > options_.last_frame || index <= last_given_)
            return;
        Partial& partial = waiting_[index];
        partial.posed = posed;
        (is_main ? partial.main_bytes : partial.small_bytes) = picture.bytes;
        auto& place = is_main ? partial.main : partial.small;
        place = ReceivedPicture{
            std::move(*picture.info), std::move(picture.rgb), {}, picture.decode_ms, picture.convert_ms};
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

    ReceivedFrame finish(Partial partial) {
        if (!partial.posed)
            partial.small.reset();
        count(given_main_, partial.main_bytes);
        if (partial.small)
            count(given_small_, partial.small_bytes);
        return {std::move(*partial.main), std::move(partial.small), partial.posed, {}};
    }

    static void count(FeedTrack& track, std::int64_t bytes) {
        track.pictures += 1;
        track.bytes += bytes;
    }

    StreamReader reader_;
    FeedOptions options_;
    std::map<std::int64_t, Partial> waiting_;
    std::int64_t last_given_ = -1;
    Track main_, small_;
    std::vector<DecodedPicture> unjudged_;  // of the main track
    FeedTrack given_main_, given_small_;
    std::int64_t foreign_index_ = 0;
    double file_bytes_ = 0;
    bool has_small_ = false;
    bool ended_ = false;
};

}  // namespace

std::unique_ptr<FrameFeed> open_stream_feed(const std::string& source, const FeedOptions& options) {
    return std::make_unique<StreamFeed>(source, options);
}

}  // namespace equistream
