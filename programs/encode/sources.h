#pragma once
/// Which folders and frames of a render become which tracks.
#include <equistream/stream.h>
#include <programs/cli/program.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// Gap filling tracks beside the main one, as --fill lists them: `small`, `hidden`, `patches`.
struct FillTracks {
    bool automatic = true;         ///< those whose folders are there
    std::vector<TrackRole> roles;  ///< those that must be there, where not automatic
};

/// "auto", "none", or names with commas between; throws InputError naming the accepted words.
FillTracks parse_fill_tracks(const std::string& list);

struct SourceRequest {
    std::filesystem::path folder;    ///< a render's folder, or one eye's within it
    std::optional<std::string> eye;  ///< centre, left or right
    FillTracks fill;
    std::optional<cli::FrameRange> frames;
    /// Both eyes in main's pictures, for ordinary players: those of left/ and right/, and nothing beside them.
    StereoPacking packing = StereoPacking::none;
};

struct SourceTrack {
    TrackRole role = TrackRole::main;
    std::filesystem::path folder;
};

struct Sources {
    std::vector<SourceTrack> tracks;   ///< main first, then the window where there is one
    std::vector<std::int64_t> frames;  ///< ascending, without gaps, there in every track
    StereoPacking packing = StereoPacking::none;
    std::filesystem::path right_eye{};    ///< where both eyes are packed: main's folder has the left one's frames
    std::vector<std::string> left_out{};  ///< other eyes' folders beside main's

    /// Whose pixels eyes look at: the window's, where there is one, else main's.
    const SourceTrack& looked_at() const;
};

/// Throws InputError naming the folder or frame that is missing.
Sources find_sources(const SourceRequest& request);

}  // namespace equistream
