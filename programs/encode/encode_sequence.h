#pragma once
/// EXR sequences through the display transform into a stream.
#include "depth_tracks.h"
#include "source_pictures.h"

#include <equistream/stream.h>

#include <algorithm>
#include <functional>

namespace equistream {

/// Colours of what fills gaps are seen in few pixels, and noise that is coded there is dear (docs/decisions/0004); in
/// the small view its pixels have averaged some away.
inline double default_fill_crf(TrackRole role, double crf) {
    return std::min(crf + (role == TrackRole::small ? 8 : 12), 51.0);
}

/// Of a sphere around a window, which is seen in few pixels too, and blurred: 8 more halve its bytes
/// (docs/decisions/0016-defaults.md).
inline double base_crf(double crf) {
    return std::min(crf + 8, 51.0);
}

struct TileRequest {
    TileGrid grid;
    std::optional<int> base_columns;  ///< nothing: a sixth of main's
};

struct EncodeRequest {
    Sources sources;
    std::string target;
    DepthRequest depth;
    bool motion = false;               ///< what moves by itself goes with main's pictures
    std::optional<TileRequest> tiles;  ///< main is sent so
    std::optional<double> fill_crf;    ///< of the gap filling tracks' colour; nothing: as default_fill_crf
    StreamSettings settings;           ///< tracks, frame rate, scene, sphere and length are filled from the frames
};

struct EncodedTrack {
    TrackSettings settings;
    int tiles = 1;  ///< so many tracks alike, of which the other figures are sums
    std::filesystem::path folder;
    std::int64_t bytes = 0;
    std::optional<DepthRange> range{};  ///< of a depth track: of its first group
    double bound_rad = 0;             ///< of a depth track: the worst that its code displaces a point by, in any group
    std::int64_t clamped_pixels = 0;  ///< of a depth track: coded farther away than they are, in all its pictures
};

struct EncodeReport {
    std::vector<EncodedTrack> tracks;
    StreamSettings settings;
    ColourTrial colour;                           ///< nothing of what is no client's: ordinary video
    std::string not_measured;                     ///< why what coding takes could not be measured; else empty
    bool sphere_tag = false;                      ///< as the container holds it
    FrameInfo first;                              ///< the main track's first frame
    std::optional<DepthTrial> trial;              ///< of main's depth, where its CRF was looked for
    std::optional<double> images_left_out_share;  ///< as DepthPlan has it
    std::optional<MotionTotals> motion;           ///< where it was asked for
    std::int64_t not_finite_samples = 0;
    double read_ms = 0;  ///< sums over all pictures
    double display_ms = 0;
    double motion_ms = 0;
    double encode_ms = 0;
    double wall_ms = 0;
};

/// `progress` is told the number of frames done, 0 when what is tried before has ended. What it throws ends the stream
/// there.
EncodeReport encode_sequence(const EncodeRequest& request, const std::function<void(std::size_t)>& progress);

}  // namespace equistream
