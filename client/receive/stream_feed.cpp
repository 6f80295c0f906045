#include "decoded_pictures.h"
#include "feeds.h"
#include "foreign_numbers.h"

#include <client/transport/address.h>
#include <client/transport/server_connection.h>
#include <client/warp/engine.h>
#include <equistream/bound.h>
#include <equistream/camera_limits.h>
#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <sstream>
#include <tuple>
#include <utility>

namespace equistream {

namespace {

/// A picture is waited for until a later one of its track has come, or so much is held: tracks are interleaved only
/// roughly (a fragmented mp4 may bring a group of one, then of the other), and one may simply have ended. A few frames
/// are held however large: decoders hold back different numbers of pictures.
constexpr std::size_t max_held_frames = 64, always_held_frames = 4;

/// A track is somebody else's if its first pictures carry no frame data; a single one of ours may have lost it.
constexpr int pictures_to_judge_by = 4;

std::string transfer_of(const StreamTrackSummary& track) {
    std::istringstream words(track.colour);
    std::string word;
    for (int i = 0; i < 3; ++i)
        std::getline(words, word, '/');
    return word;
}

/// Of the colours alone: the first picture has the bytes and the times of both.
void swap_eyes(DecodedPicture& left, DecodedPicture& right) {
    std::swap(left.rgb, right.rgb);
    std::swap(left.yuv, right.yuv);
    std::swap(left.pq, right.pq);
}

class StreamFeed : public FrameFeed {
public:
    StreamFeed(const std::string& source, const FeedOptions& options, std::size_t max_held_bytes)
        : source_(without_secrets(source)), reader_(source_, connected(source,
                                                                       {.rgb = true,
                                                                        .yuv = options.yuv,
                                                                        .pq = true,
                                                                        .depth = options.depth,
                                                                        .images = options.specular,
                                                                        .left_out = asked_to_leave_out(options),
                                                                        .hardware = options.hardware,
                                                                        .memory = options.memory,
                                                                        .interrupted = options.interrupted},
                                                                       options.poses)),
          options_(options), max_held_bytes_(max_held_bytes), left_out_(asked_to_leave_out(options)),
          tracks_(reader_.tracks().size()) {
        std::error_code error;
        const auto size = std::filesystem::file_size(source, error);
        file_bytes_ = error ? 0 : double(size);
        learn_roles();
    }

    std::optional<ReceivedFrame> next() override {
        left_out_ |= asked_to_leave_out(options_);
        reader_.leave_out(left_out_);
        for (;;) {
            while (!first_is_settled() && !ended_) {
                if (waiting_.empty() && main_is_past())
                    ended_ = true;
                else
                    take(reader_.next());
            }
            if (waiting_.empty())
                return std::nullopt;
            auto first = waiting_.extract(waiting_.begin());
            if (first.mapped().picture(TrackRole::main)) {
                last_given_ = first.key();
                return maker_.make(std::move(first.mapped()));
            }
            // The main picture is lost: the others alone show nothing.
        }
    }

    std::string truncation() const override { return reader_.truncation(); }
    std::vector<FeedTrack> tracks() const override {
        std::vector<FeedTrack> given;
        for (const Track& track : tracks_) {
            auto same = std::ranges::find(given, track_name(track.role), &FeedTrack::name);
            if (!is_tile(track) || same == given.end())
                same = given.insert(given.end(), {track_name(track.role), 0, 0});
            same->pictures += track.given_pictures;
            same->bytes += track.given_bytes;
        }
        return given;
    }
    std::optional<double> fraction_done() const override {
        return file_bytes_ > 0 ? std::optional(std::min(1.0, double(reader_.position()) / file_bytes_)) : std::nullopt;
    }
    bool is_live() const override { return reader_.is_live(); }
    std::vector<std::string> transfers() const override {
        std::vector<std::string> names;
        for (const StreamTrackSummary& track : reader_.tracks())
            names.push_back(transfer_of(track));
        return names;
    }
    FeedSummary summary() const override {
        const auto main = std::ranges::find(reader_.tracks(), TrackRole::main, &StreamTrackSummary::role);
        return {.kind = reader_.container(),
                .codec = main == reader_.tracks().end() ? std::string() : main->codec,
                .seconds = reader_.seconds(),
                .frames = {}};
    }
    bool seek(std::int64_t frame) override {
        const double time_s = begun_ ? double(frame - begun_->index) / begun_->frames_per_second : 0;
        if (!begun_ || !reader_.seek(time_s))
            return false;
        options_.first_frame = frame;
        waiting_.clear();
        unjudged_.clear();
        last_given_ = frame - 1;
        foreign_.jump(time_s);
        ended_ = false;
        for (Track& track : tracks_)
            track.last = -1;
        return true;
    }

private:
    enum class Origin { unknown, ours, foreign };
    struct Track {
        TrackRole role = TrackRole::main;  // as the reader says
        Origin origin = Origin::unknown;
        int without_data = 0;    // pictures, while the origin is unknown
        std::int64_t last = -1;  // pictures of a track come in order: an earlier one that is not here is lost
        std::int64_t given_pictures = 0, given_bytes = 0;

        void judge_by(const DecodedPicture& picture) {
            if (origin == Origin::unknown && picture.info)
                origin = Origin::ours;
            else if (origin == Origin::unknown && ++without_data == pictures_to_judge_by)
                origin = Origin::foreign;
        }
    };

    /// What nobody asked for does not come.
    bool is_expected(const Track& track) const {
        const StreamReadOptions asked{.depth = options_.depth, .images = options_.specular, .left_out = left_out_};
        return track.origin != Origin::foreign && asked.wants(track.role);
    }

    /// All pictures of the first waiting frame are here, or will not come.
    bool first_is_settled() const {
        if (waiting_.empty())
            return false;
        const auto& [index, first] = *waiting_.begin();
        for (std::size_t i = 0; i < tracks_.size(); ++i) {
            const Track& track = tracks_[i];
            if (!is_expected(track))
                continue;
            if (is_tile(track) ? track.last < index && tile_goes_with(i, first)
                               : !(track.origin == Origin::ours && first.picture(track.role)) && track.last <= index)
                return holds_too_much();
        }
        return true;
    }

    /// Main's pictures come in order: no frame that was asked for follows.
    bool main_is_past() const {
        const auto main = std::ranges::find(tracks_, TrackRole::main, &Track::role);
        return main != tracks_.end() && main->last > options_.last_frame;
    }

    void learn_roles() {
        tracks_of_role_.fill(0);
        for (std::size_t i = 0; i < tracks_.size(); ++i) {
            tracks_[i].role = reader_.tracks()[i].role;
            ++tracks_of_role_[std::size_t(tracks_[i].role)];
        }
    }
    bool is_tile(const Track& track) const {
        return may_be_tiled(track.role) && tracks_of_role_[std::size_t(track.role)] > 1;
    }
    /// All tiles of a file do. A server sends those that are looked at, before the main picture that they go with.
    /// Where that is lost, no tile is waited for.
    bool tile_goes_with(std::size_t track, const DecodedFrame& frame) const {
        const auto& main = frame.picture(TrackRole::main);
        if (!reader_.is_live() || (main && !main->time_s))
            return true;
        if (!main)
            return false;
        const std::optional<double> newest_s = reader_.newest_s(track);
        return newest_s && *newest_s >= *main->time_s - container_rounding_s &&
               tracks_.front().last <= main->info->index;
    }

    bool holds_too_much() const {
        std::size_t bytes = 0;
        for (const auto& [index, partial] : waiting_) {
            bytes += partial.bytes();
            for (const auto& [place, tile] : partial.tiles)
                bytes += tile.bytes();
        }
        return waiting_.size() > max_held_frames || (waiting_.size() > always_held_frames && bytes > max_held_bytes_);
    }

    void take(std::optional<DecodedPicture> decoded) {
        if (!decoded) {
            ended_ = true;
            if (origin_of_main() == Origin::unknown)
                take_for_foreign();
            return;
        }
        learn_roles();  // of tracks that are left out nothing comes
        Track& track = tracks_[decoded->track];
        track.judge_by(*decoded);
        const bool is_main = track.role == TrackRole::main;
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
        if (decoded->info && track.origin == Origin::ours && origin_of_main() != Origin::foreign)
            keep(std::move(*decoded), true);
    }

    Origin origin_of_main() const {
        const auto main = std::ranges::find(tracks_, TrackRole::main, &Track::role);
        return main == tracks_.end() ? Origin::unknown : main->origin;
    }

    void take_for_foreign() {
        for (Track& track : tracks_)
            track.origin = Origin::foreign;
        for (DecodedPicture& picture : std::exchange(unjudged_, {})) {
            if (foreign_.is_before_jump(picture.time_s, foreign_rate()))
                continue;
            std::optional<DecodedPicture> right;
            if (packing() != StereoPacking::none)
                right = split_eyes(picture, packing());
            if (right && reader_.tracks().front().right_first)
                swap_eyes(picture, *right);
            picture.info = foreign_info(picture);
            if (right)
                right->info = picture.info;
            keep(std::move(picture), false, std::move(right));
        }
    }

    /// Of foreign video.
    StereoPacking packing() const { return reader_.tracks().front().stereo; }

    /// `picture` has its info; beside it the right eye's, where it is the left one's.
    void keep(DecodedPicture picture, bool posed, std::optional<DecodedPicture> right = {}) {
        Track& track = tracks_[picture.track];
        const std::int64_t index = picture.info.value().index;
        if (!begun_ && track.role == TrackRole::main)
            begun_ = {index, picture.info->frames_per_second};
        track.last = std::max(track.last, index);
        if (index < options_.first_frame || index > options_.last_frame || index <= last_given_)
            return;
        DecodedFrame& partial = waiting_[index];
        partial.posed = posed;
        if (right)
            partial.right = std::move(right);
        std::optional<DecodedPicture>& of_role = partial.picture(picture.role);
        if (!is_tile(track)) {
            of_role = std::move(picture);
            return;
        }
        // Where the container has no names the first tile was taken for a window alone.
        if (of_role)
            keep_tile(*std::exchange(of_role, std::nullopt), partial);
        keep_tile(std::move(picture), partial);
    }
    void keep_tile(DecodedPicture picture, DecodedFrame& partial) const {
        const auto* camera = std::get_if<EquirectCamera>(&picture.info->camera);
        if (camera == nullptr)
            throw WorkError(expected_found(source_ + ": frame " + std::to_string(picture.info->index) + " of window",
                                           "a part of a sphere", "a flat view"));
        DecodedPictures& tile = partial.tiles[{camera->range.longitude_min, camera->range.latitude_max}];
        tile.picture(picture.role) = std::move(picture);
    }

    double foreign_rate() const {
        const double per_second = reader_.tracks().front().max_frames_per_second;
        return range_mismatch(per_second, 1e-6, 1e6) ? FrameInfo{}.frames_per_second : per_second;
    }

    /// Video without our data is taken for a full sphere, unless it is tagged with a part of one.
    FrameInfo foreign_info(const DecodedPicture& picture) {
        FrameInfo info;
        info.frames_per_second = foreign_rate();
        std::tie(info.index, info.time_s) = foreign_.next(picture.time_s, info.frames_per_second);
        info.camera = EquirectCamera{picture.width, picture.height,
                                     reader_.tracks().front().sphere.value_or(LongitudeLatitudeRange{})};
        return info;
    }

    void count(const DecodedPicture& picture) {
        tracks_[picture.track].given_pictures += 1;
        tracks_[picture.track].given_bytes += picture.bytes;
    }

    std::string source_;
    StreamReader reader_;
    FeedOptions options_;
    std::size_t max_held_bytes_;
    TrackRoles left_out_;
    std::map<std::int64_t, DecodedFrame> waiting_;
    std::int64_t last_given_ = -1;
    std::array<int, track_role_count> tracks_of_role_{};
    std::vector<Track> tracks_;             // as the reader's
    std::vector<DecodedPicture> unjudged_;  // of the main track
    ForeignNumbers foreign_;
    struct Beginning {
        std::int64_t index;
        double frames_per_second;
    };
    std::optional<Beginning> begun_;  // with main's first picture
    FrameMaker maker_{source_, options_, [this](const DecodedPicture& picture) { count(picture); }};
    double file_bytes_ = 0;
    bool ended_ = false;
};

}  // namespace

std::unique_ptr<FrameFeed> open_stream_feed(const std::string& source, const FeedOptions& options,
                                            std::size_t max_held_bytes) {
    return std::make_unique<StreamFeed>(source, options, max_held_bytes);
}

}  // namespace equistream
