#include "describe.h"

#include <client/transport/address.h>
#include <client/transport/server_connection.h>
#include <equistream/stream.h>
#include <programs/cli/provenance.h>

#include <algorithm>

namespace equistream {

namespace {

/// One track, or all tiles of a role as one: the first one's frames, and the sum of their pictures and bytes.
struct Entry {
    StreamTrackSummary track;
    int tiles = 1;
    std::vector<FrameInfo> frames;
};

/// Main pictures that are looked at of what may have no end.
constexpr std::int64_t most_watched = 300;

struct Watched {
    StreamReader reader;
    std::vector<std::vector<FrameInfo>> frames;  ///< by track
    bool is_partial = false;                     ///< it went on

    explicit Watched(const std::string& source)
        : reader(source, connected(source, {.rgb = false})), frames(reader.tracks().size()) {
        const bool may_be_endless = parse_server_address(source).has_value();
        while (!is_partial) {
            const auto picture = reader.next();
            if (!picture)
                return;
            if (picture->info)
                frames[picture->track].push_back(*picture->info);
            is_partial = may_be_endless && reader.tracks().front().pictures >= most_watched;
        }
    }

    std::vector<Entry> entries() const {
        std::vector<Entry> all;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const StreamTrackSummary& track = reader.tracks()[i];
            const auto same = std::ranges::find_if(all, [&](const Entry& entry) {
                return may_be_tiled(track.role) && entry.track.role == track.role && !frames[i].empty();
            });
            if (same == all.end()) {
                all.push_back({track, 1, frames[i]});
                continue;
            }
            ++same->tiles;
            same->track.pictures += track.pictures;
            same->track.bytes += track.bytes;
        }
        return all;
    }
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
        text += "  vexu       Apple's box is there" +
                (track.baseline_m ? formatted(", with %.1f mm between the eyes", *track.baseline_m * 1e3) : "") + "\n";
    return text;
}

double bytes_a_picture(const StreamTrackSummary& track) {
    return track.pictures > 0 ? static_cast<double>(track.bytes) / static_cast<double>(track.pictures) : 0;
}

/// What main's pictures say of what moves.
struct Moving {
    std::size_t pictures = 0, max_regions = 0, bytes = 0;

    explicit Moving(const std::vector<FrameInfo>& frames) {
        for (const FrameInfo& frame : frames) {
            pictures += !frame.moving.empty();
            max_regions = std::max(max_regions, frame.moving.size());
            bytes += motion_bytes(frame);
        }
    }
};

std::string moving_text(const std::vector<FrameInfo>& frames) {
    const Moving moving(frames);
    if (moving.pictures == 0)
        return "";
    return formatted("  motion     in %zu pictures, of up to %zu bodies: %s a picture\n", moving.pictures,
                     moving.max_regions, bytes_text(double(moving.bytes) / double(frames.size())).c_str());
}

nlohmann::json moving_json(const std::vector<FrameInfo>& frames) {
    const Moving moving(frames);
    return {{"pictures", moving.pictures}, {"most_regions", moving.max_regions}, {"bytes", moving.bytes}};
}

std::string track_text(const Entry& entry, bool each_frame) {
    const auto& [track, tiles, frames] = entry;
    const std::string count = tiles == 1 ? "" : std::to_string(tiles) + " tiles of ";
    std::string text =
        formatted("track %s: %s, %s%dx%d %s, %.3f frames/s, %lld pictures, %s (%s a picture)\n",
                  frames.empty() ? shown(track.name).c_str() : track_name(track.role), track.codec.c_str(),
                  count.c_str(), track.width, track.height, track.pixel_format.c_str(), track.frames_per_second,
                  static_cast<long long>(track.pictures), bytes_text(static_cast<double>(track.bytes)).c_str(),
                  bytes_text(bytes_a_picture(track)).c_str());
    text += "  colour     " + track.colour + " (range/primaries/transfer/matrix)\n";
    text += tags_text(track);
    if (track.pictures == 0)
        return text + "  no picture could be read\n";
    if (frames.empty())
        return text + "  no frame data of equistream's: an ordinary video, which can be shown but only turned\n";
    text += formatted("  frames     %lld to %lld, each with its pose in the coded picture\n",
                      static_cast<long long>(frames.front().index), static_cast<long long>(frames.back().index));
    text += range_text(frames) + shared_text(frames.front()) + moving_text(frames);
    return each_frame ? text + each_text(frames) : text;
}

nlohmann::json track_json(const Entry& entry, bool each_frame) {
    const auto& [track, tiles, frames] = entry;
    nlohmann::json json = {{"name", frames.empty() ? track.name : std::string(track_name(track.role))},
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
                           {"motion", moving_json(frames)},
                           {"first_frame", frames.empty() ? nlohmann::json() : frame_json(frames.front())}};
    if (each_frame)
        for (const FrameInfo& frame : frames)
            json["frames"].push_back(frame_json(frame));
    return json;
}

}  // namespace

Description describe_stream(const std::string& source, const DescribeOptions& options) {
    const Watched watched(source);
    const std::string& cut = watched.reader.truncation();
    Description description;
    description.json = {{"kind", "stream"},     {"source", source},  {"container", watched.reader.container()},
                        {"whole", cut.empty()}, {"truncation", cut}, {"tracks", nlohmann::json::array()}};
    if (watched.is_partial)
        description.json["whole"] = nullptr;
    description.text = shown(source) + ": video, " + watched.reader.container() + "\n";
    for (const Entry& entry : watched.entries()) {
        nlohmann::json track = track_json(entry, options.each_frame);
        if (is_url(source))
            track["vexu"] = nullptr;  // boxes are read in files alone
        description.json["tracks"].push_back(std::move(track));
        description.text += track_text(entry, options.each_frame);
    }
    const std::string most = std::to_string(most_watched);
    description.text += watched.is_partial ? "partial: only the server's first " + most + " pictures were read\n"
                        : cut.empty()      ? "whole: nothing is missing\n"
                                           : "not whole: " + cut + "\n";
    return description;
}

}  // namespace equistream
