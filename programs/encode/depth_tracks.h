#pragma once
/// Depth tracks of a stream to be, and the one of mirrors and glass: which code, how good, and for which depths.
#include "colour_trial.h"
#include "sources.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/frame.h>

#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// Whether mirrors and glass get a track, where main has some. Cheap: no more of main's colour bits than depth may take
/// (DepthRequest::share). What is seen in panes behind foliage is all outlines, which cost the most.
enum class ImagesTrack { none, if_cheap, always };

struct DepthRequest {
    std::string code = "none";  ///< auto, none, or a depth code's name
    /// Of the main colour track's bits that all tracks of distances may take together; nothing: shares().
    std::optional<double> share;
    std::optional<double> crf;  ///< nothing: the best within that share
    /// Main's depth at half the columns and rows; nothing: what suits that share, or all of them where the CRF is
    /// given.
    std::optional<bool> halved;
    ImagesTrack images = ImagesTrack::if_cheap;

    /// To try, the least first: more where less leaves few pixels within the bound. Clean colour takes so few bits that
    /// a tenth of them starves depth.
    std::vector<double> shares() const { return share ? std::vector{*share} : std::vector{0.1, 0.2, 0.3}; }
};

/// One colour track's depth, or main's mirrors and glass.
struct DepthTrack {
    TrackRole role = TrackRole::depth;
    SourceTrack source;       ///< the colour it belongs to
    double box_radius_m = 0;  ///< of the ball that eyes stay in around any of the picture's origins
    DepthCodeId code = DepthCodeId::w10;
    std::optional<double> crf;
    bool halved = false;  ///< half the columns and rows
    /// Of the views that the error budget is for, pixels; of a base: base_focal_length_px.
    double focal_length_px = default_focal_length_px;
    /// Of a hidden layer: main's frames, whose depth it gets where it holds nothing. Empty: it stays as it is.
    std::filesystem::path main_folder{};
    /// Where both eyes are packed: the right one's frames, whose distances are in the same pictures. Else empty.
    std::filesystem::path right_eye{};
};

/// Main's depth may be coded in any of these ways.
struct DepthWay {
    DepthCodeId code = DepthCodeId::w12;
    bool halved = false;
};

/// Ranges of one depth track: the same throughout a group of pictures, as near as its nearest surface.
class DepthRanges {
public:
    /// `frames` and `gop` as they will be coded.
    DepthRanges(const DepthTrack& track, std::vector<std::int64_t> frames, int gop);

    /// Of the frame at this position; reads the group's depth when the group is new.
    DepthRange of(std::size_t position) { return of(position, {track_.code, track_.halved}); }
    /// The same coded in another way.
    DepthRange of(std::size_t position, const DepthWay& way);

private:
    DepthTrack track_;
    std::vector<std::int64_t> frames_;
    std::size_t gop_;
    std::size_t group_ = SIZE_MAX;
    double nearest_m_ = 0;
    bool has_empty_ = false;
};

/// What tracks of distances stand beside; borrows.
struct Beside {
    const Sources& sources;
    const StreamSettings& settings;  ///< the stream's, all but its tracks
    ColourTrials& colour;
    std::optional<WindowGrid> tile{};  ///< where the main sphere is coded in tiles
};

/// How main's depth fared in a trial on a few frames.
struct DepthTrial {
    double crf = 0;
    double bytes = 0;         ///< a frame, of all tracks that were tried
    double colour_bytes = 0;  ///< a frame of main's colour at the stream's own CRF
    double within = 0;        ///< share of pixels that, coded, no eye sees displaced by more than the error budget
    int frames = 0;
    double allowed = 0;  ///< share of the colour's bytes that these were to stay within

    double share() const { return bytes / colour_bytes; }
};

struct DepthPlan {
    std::vector<DepthTrack> tracks;   ///< empty: none
    std::optional<DepthTrial> trial;  ///< with what was chosen; nothing where there was nothing to choose
    /// Of main's colour bits, where mirrors and glass would have taken so many that they were left out.
    std::optional<double> images_left_out_share{};
};

// What tracks of distances cost, and how depth is best coded for that, tried on a few frames (depth_trial.cpp).

/// A track as it is, on the same few frames.
DepthTrial try_track(const DepthTrack& track, const Beside& beside);

/// Gives main's depth the code and the size, of those that the request leaves open, and all tracks the CRF, that leave
/// most of main's pixels within the bound while the bytes of all tracks together stay within the share asked for;
/// of those that leave practically all there, the cheapest. Does nothing where main has no depth, where the CRF was
/// given or where it does not matter. Of several shares to try takes the least that leaves enough pixels there, or that
/// the next one hardly betters.
void choose_depth(const DepthRequest& request, const Beside& beside, DepthPlan& plan);

/// Whether depth of such pictures may be coded at half the columns and rows.
bool can_be_halved(int width, int height);

/// Planes of a rendered frame that a track of distances is made of.
std::vector<std::string> planes_of(TrackRole role);
/// As a track has them: metres, +inf for a miss, NaN where the picture holds no surface, or no mirror or glass that
/// shows what moves otherwise than its surface. An image whose distance the renderer does not know counts as far away.
/// `frame` was read from `file` with the planes of planes_of().
FloatImage distances_to_code(const DepthTrack& track, const Frame& frame, const std::filesystem::path& file);

/// Chooses codes, size and CRF for the depth of all colour tracks that have some. Hidden layers have depth whatever was
/// asked for main, at the stream's CRF if main has none; patches if main has. Mirrors and glass get a track if the
/// first frame of any of a few groups, spread over all of them, shows some and request.images allows it. Throws
/// InputError where depth was asked for and cannot be had.
DepthPlan plan_depth(const DepthRequest& request, const Beside& beside);

}  // namespace equistream
