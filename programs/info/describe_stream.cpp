#include "describe.h"

#include <client/transport/address.h>
#include <client/transport/server_connection.h>
#include <equistream/stream.h>
#include <programs/cli/provenance.h>

#include <algorithm>
#include <utility>

namespace equistream {

namespace {

/// What main's pictures say of what moves.
struct Moving {
    std::size_t pictures = 0, max_regions = 0, bytes = 0;

    void add(const FrameInfo& frame) {
        pictures += !frame.moving.empty();
        max_regions = std::max(max_regions, frame.moving.size());
        bytes += motion_bytes(frame);
    }
};

/// Of one track's pictures.
struct Seen {
    FrameRun frames;
    Moving moving;
    Description list;  ///< of the frames, where it is asked for
};

/// One track, or all tiles of a role as one: what the first one's pictures say, and the sum of their pictures and
/// bytes.
struct Entry {
    StreamTrackSummary track;
    int tiles = 1;
    Seen seen{};
};

/// Main pictures that are looked at of what may have no end.
constexpr std::int64_t max_watched = 300;

class Watched {
public:
    StreamReader reader;
    bool is_partial = false;  ///< it went on

    Watched(const std::string& source, const DescribeOptions& options)
        : reader(source, connected(source, {.rgb = false})), may_be_endless_(parse_server_address(source).has_value()),
          seen_(reader.tracks().size()) {
        std::error_code error;  // what is no file has no size
        const std::uintmax_t size = std::filesystem::file_size(source, error);
        file_bytes_ = error ? 0 : double(size);
        cli::Progress progress("info", 1, options.progress);
        while (!is_partial) {
            const auto picture = reader.next();
            if (!picture)
                return;
            if (picture->info)
                add(picture->track, *picture->info, options);
            if (picture->track == 0)
                progress.step(fraction_done(), "picture " + std::to_string(main_pictures()));
            is_partial = may_be_endless_ && main_pictures() >= max_watched;
        }
    }

    /// Once.
    std::vector<Entry> take_entries() {
        std::vector<Entry> all;
        for (std::size_t i = 0; i < seen_.size(); ++i) {
            const StreamTrackSummary& track = reader.tracks()[i];
            const auto same = std::ranges::find_if(all, [&](const Entry& entry) {
                return may_be_tiled(track.role) && entry.track.role == track.role && seen_[i].frames.count > 0;
            });
            if (same == all.end()) {
                all.push_back({track, 1, std::move(seen_[i])});
                continue;
            }
            ++same->tiles;
            same->track.pictures += track.pictures;
            same->track.bytes += track.bytes;
        }
        return all;
    }

private:
    std::int64_t main_pictures() const { return reader.tracks().front().pictures; }

    /// 0 where it cannot be known.
    double fraction_done() const {
        if (may_be_endless_)
            return double(main_pictures()) / double(max_watched);
        return file_bytes_ > 0 ? std::min(1.0, double(reader.position()) / file_bytes_) : 0;
    }

    void add(std::size_t track, const FrameInfo& frame, const DescribeOptions& options) {
        Seen& seen = seen_[track];
        seen.frames.add(frame);
        seen.moving.add(frame);
        if (options.each_frame && !is_further_tile(track))
            list_frame(frame, options, seen.list);
    }

    /// Only the first tile's frames are told.
    bool is_further_tile(std::size_t track) const {
        const auto& tracks = reader.tracks();
        const TrackRole role = tracks[track].role;
        return may_be_tiled(role) &&
               std::ranges::find(tracks, role, &StreamTrackSummary::role) != tracks.begin() + std::ptrdiff_t(track);
    }

    bool may_be_endless_;
    double file_bytes_ = 0;
    std::vector<Seen> seen_;  ///< by track
};

const char* stereo_name(StereoPacking packing) {
    return packing_names[static_cast<int>(packing)];
}

/// What ordinary players are told of how to show the track.
std::string tags_text(const StreamTrackSummary& track) {
    std::string text;
    constexpr double degrees = 180 / pi;
    if (track.sphere && track.sphere->is_full_sphere())
        text += "  sphere     tagged as equirectangular: ordinary 360 degree players show it\n";
    else if (track.sphere)
        text +=
            formatted("  sphere     tagged as part of an equirectangular one: longitude %.1f to %.1f, latitude %.1f "
                      "to %.1f degrees\n",
                      track.sphere->longitude_min * degrees, track.sphere->longitude_max * degrees,
                      track.sphere->latitude_min * degrees, track.sphere->latitude_max * degrees);
    if (track.stereo != StereoPacking::none)
        text += formatted("  stereo     tagged as both eyes in each picture: %s%s\n", stereo_name(track.stereo),
                          track.right_first ? ", the right one first" : "");
    if (track.has_vexu)
        text += "  vexu       Apple's stereo box is present" +
                (track.baseline_m ? formatted(", with %.1f mm between the eyes", *track.baseline_m * 1e3) : "") + "\n";
    return text;
}

double bytes_a_picture(const StreamTrackSummary& track) {
    return track.pictures > 0 ? static_cast<double>(track.bytes) / static_cast<double>(track.pictures) : 0;
}

std::string moving_text(const Seen& seen) {
    const Moving& moving = seen.moving;
    if (moving.pictures == 0)
        return "";
    return formatted("  motion     in %zu pictures, of up to %zu bodies: %s a picture\n", moving.pictures,
                     moving.max_regions, bytes_text(double(moving.bytes) / double(seen.frames.count)).c_str());
}

nlohmann::json moving_json(const Moving& moving) {
    return {{"pictures", moving.pictures}, {"most_regions", moving.max_regions}, {"bytes", moving.bytes}};
}

std::string track_text(const Entry& entry) {
    const auto& [track, tiles, seen] = entry;
    const FrameRun& frames = seen.frames;
    const std::string count = tiles == 1 ? "" : std::to_string(tiles) + " tiles of ";
    std::string text =
        formatted("track %s: %s, %s%dx%d %s, %.3f frames/s, %lld pictures, %s (%s a picture)\n",
                  frames.count == 0 ? shown(track.name).c_str() : track_name(track.role), track.codec.c_str(),
                  count.c_str(), track.width, track.height, track.pixel_format.c_str(), track.frames_per_second,
                  static_cast<long long>(track.pictures), bytes_text(static_cast<double>(track.bytes)).c_str(),
                  bytes_text(bytes_a_picture(track)).c_str());
    text += "  colour     " + track.colour + " (range/primaries/transfer/matrix)\n";
    text += tags_text(track);
    if (track.pictures == 0)
        return text + "  no picture could be read\n";
    if (frames.count == 0)
        return text + "  no equistream frame data: ordinary video, which clients can only rotate\n";
    text += formatted("  frames     %lld to %lld, each with its pose in the coded picture\n",
                      static_cast<long long>(frames.first.index), static_cast<long long>(frames.last_index));
    return text + range_text(frames) + shared_text(frames.first) + moving_text(seen) + seen.list.text;
}

nlohmann::json track_json(Entry& entry) {
    auto& [track, tiles, seen] = entry;
    const FrameRun& frames = seen.frames;
    nlohmann::json json = {{"name", frames.count == 0 ? track.name : std::string(track_name(track.role))},
                           {"tiles", tiles},
                           {"codec", track.codec},
                           {"width", track.width},
                           {"height", track.height},
                           {"pixel_format", track.pixel_format},
                           {"frames_per_second", track.frames_per_second},
                           {"pictures", track.pictures},
                           {"bytes", track.bytes},
                           {"colour", track.colour},
                           {"equirect", track.sphere.has_value()},
                           {"stereo", stereo_name(track.stereo)},
                           {"right_first", track.right_first},
                           {"vexu", track.has_vexu},
                           {"baseline_m", cli::or_null(track.baseline_m)},
                           {"range", range_json(frames)},
                           {"motion", moving_json(seen.moving)},
                           {"first_frame", frames.count == 0 ? nlohmann::json() : frame_json(frames.first)}};
    if (!seen.list.json.is_null())
        json["frames"] = std::move(seen.list.json);
    return json;
}

}  // namespace

Description describe_stream(const std::string& source, const DescribeOptions& options) {
    Watched watched(source, options);
    const std::string& cut = watched.reader.truncation();
    Description description;
    description.json = {{"kind", "stream"},     {"source", source},  {"container", watched.reader.container()},
                        {"whole", cut.empty()}, {"truncation", cut}, {"tracks", nlohmann::json::array()}};
    if (watched.is_partial)
        description.json["whole"] = nullptr;
    description.text = shown(source) + ": video, " + watched.reader.container() + "\n";
    for (Entry& entry : watched.take_entries()) {
        nlohmann::json track = track_json(entry);
        if (is_url(source))
            track["vexu"] = nullptr;  // boxes are read in files alone
        description.json["tracks"].push_back(std::move(track));
        description.text += track_text(entry);
    }
    const std::string most = std::to_string(max_watched);
    description.text += watched.is_partial ? "partial: only the server's first " + most + " pictures were read\n"
                        : cut.empty()      ? "whole: nothing is missing\n"
                                           : "not whole: " + cut + "\n";
    return description;
}

}  // namespace equistream
