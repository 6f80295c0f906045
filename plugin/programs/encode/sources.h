#pragma once
/// Which folders and frames of a render become which tracks.
#include <equistream/stream.h>
#include <equistream_cli/program.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

enum class SmallTrack { automatic, required, none };

struct SourceRequest {
    std::filesystem::path folder;    ///< a render's folder, or one eye's within it
    std::optional<std::string> eye;  ///< centre, left or right
    SmallTrack small = SmallTrack::automatic;
    std::optional<cli::FrameRange> frames;
};

struct SourceTrack {
    TrackRole role = TrackRole::main;
    std::filesystem::path folder;
};

struct Sources {
    std::vector<SourceTrack> tracks;   ///< main first
    std::vector<std::int64_t> frames;  ///< ascending, without gaps, there in every track
};

/// Throws InputError naming the folder or frame that is missing.
Sources find_sources(const SourceRequest& request);

}  // namespace equistream
