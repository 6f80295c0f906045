#pragma once
/// Depth tracks of a stream to be: which code, how good, and for which depths.
#include "sources.h"

#include <equistream/depth_code.h>

#include <optional>
#include <string>
#include <vector>

namespace equistream {

struct DepthRequest {
    std::string code = "none";  ///< auto, none, or a depth code's name
    double share = 0.1;         ///< of the main colour track's bits that main's depth may take
    std::optional<double> crf;  ///< nothing: the best within that share
};

/// One colour track's depth.
struct DepthTrack {
    TrackRole role = TrackRole::depth;
    SourceTrack source;       ///< the colour it belongs to
    double box_radius_m = 0;  ///< of the ball that eyes stay in around any of the picture's origins
    DepthCodeId code = DepthCodeId::w10;
    std::optional<double> crf;
};

/// Ranges of one depth track: the same throughout a group of pictures, as near as its nearest surface.
class DepthRanges {
public:
    /// `frames` and `gop` as they will be coded.
    DepthRanges(const DepthTrack& track, std::vector<std::int64_t> frames, int gop);

    /// Of the frame at this position; reads the group's depth when the group is new.
    const DepthRange& of(std::size_t position);

private:
    DepthTrack track_;
    std::vector<std::int64_t> frames_;
    std::size_t gop_;
    std::size_t group_ = SIZE_MAX;
    DepthRange range_;
};

/// How main's depth fared in a trial on a few frames.
struct DepthTrial {
    double crf = 0;
    double bytes = 0;         ///< a frame
    double colour_bytes = 0;  ///< a frame of main's colour at the stream's own CRF
    double within = 0;        ///< share of pixels that, coded, no eye sees displaced by more than the error budget
    int frames = 0;

    double share() const { return bytes / colour_bytes; }
};

struct DepthPlan {
    std::vector<DepthTrack> tracks;   ///< empty: none
    std::optional<DepthTrial> trial;  ///< with what was chosen; nothing where there was nothing to choose
};

/// As a depth track has it: metres, +inf for a miss, NaN where the picture holds no surface.
FloatImage depth_to_code(FloatImage depth_m, TrackRole colour);
FloatImage read_depth(const SourceTrack& source, std::int64_t index);

/// Chooses codes and CRF for the depth of all colour tracks that have some. `settings` are the stream's, all but its
/// tracks. Hidden layers and patches have depth whatever was asked for main, at the stream's CRF if main has none.
/// Throws InputError where depth was asked for and cannot be had.
DepthPlan plan_depth(const DepthRequest& request, const Sources& sources, const StreamSettings& settings);

}  // namespace equistream
