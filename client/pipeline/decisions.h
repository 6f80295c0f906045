#pragma once
/// What the pipeline decides of a frame, once for its CPU and its GPU back end. Pure functions.
#include <equistream/depth_code_info.h>
#include <equistream/frame.h>

#include <client/confidence/reliability.h>
#include <client/receive/receive.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>
#include <client/warp/view.h>
#include <scenes/library/scene.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

/// How eyes are made of frames.
struct PipelineChoice {
    std::string engine;   ///< of engine_stages()
    std::string depth;    ///< of depth_stages(), or none
    std::string fill;     ///< a list of fill_stages()
    bool mirrors = true;  ///< whether anything asks where mirrors are
};

/// Tracks that a pipeline has no use for: they need not be decoded.
TrackRoles unneeded_roles(const PipelineChoice& choice);

/// Whether the pass `earlier` may fill from a frame of that time. A frame more than a second older, or from after a
/// jump back in time, belongs to another walk.
bool counts_as_earlier(double earlier_s, double shown_s);

/// The same of a window that the gaze has left, whose light is held to the base's: ten seconds.
bool counts_as_left(double earlier_s, double shown_s);

/// Whether two windows of one sphere show more of the same than not.
bool mostly_overlap(const Camera& a, const Camera& b);

/// What confidence is told of the main picture. `by_frames_depth`: eyes are reprojected by the depth that came with the
/// frame, whose code may be off; else by depth that has no such error.
ReliabilityOptions confidence_options(const FrameInfo& main, bool by_frames_depth, MirrorTreatment mirrors);

/// The same of colours that are so visibly off, and depth whose w may be off by so much.
ReliabilityOptions confidence_options(double depth_tolerance_w, const std::optional<VisibleLoss>& visible_loss,
                                      MirrorTreatment mirrors);

/// Whether an eye is outside the head box that the source was rendered for.
bool leaves_head_box(const Pose& eye, const FrameInfo& source);

/// Of a frame with a picture for each eye, whether this one is made of the right picture: where both are posed of the
/// one that was seen from nearer by, else of its own. False where there is none.
bool takes_right(const ReceivedFrame& frame, bool is_right_eye, const Pose& eye);

// Which engine and whose depth eyes are made by, from what was asked for and what there is (docs/guide/play.md, "Which
// method").

/// What was asked for.
struct DepthWish {
    std::string source;  ///< file, URL or folder; named in messages
    std::string method;  ///< empty: by what depth there is; auto stays auto
    std::string depth;   ///< empty: the first there is of ray and what came
    // Options by the names that their user knows, for messages.
    std::string method_option = "--method";
    std::string scene_option = "--scene S";
    std::string depth_option = "--depth";  ///< empty: depth cannot be asked for
};

/// What there is to take depth from.
struct DepthOffer {
    bool scene = false;                      ///< geometry to find depth in, by rays or by OpenGL
    bool folder = false;                     ///< the source is a folder of rendered frames, not a stream
    bool posed = true;                       ///< ordinary video has no poses, so that no depth fits it
    bool plane = false;                      ///< depth of the main picture came with it
    std::optional<DepthCodeId> code{};       ///< that plane's, in a stream
    std::optional<Eye> eye_without_plane{};  ///< whose very view no depth came of, the first such eye
};

struct DepthChoice {
    std::string method;  ///< never empty; auto stays auto
    std::string depth;   ///< of is_cast, stream, exact or none
    std::vector<std::string> notes;
};

/// Throws InputError for a depth that this source does not have, and for a method that needs one that is not there.
/// Notes name options of programs.
DepthChoice choose_depth(const DepthWish& wish, const DepthOffer& offer);

/// Throws InputError where the frames of `source` were rendered from another scene than `file`'s, or other geometry.
/// Nothing, or a note where the frames do not name their geometry.
std::optional<std::string> require_same_scene(const FrameInfo& first, const std::string& source,
                                              const SceneDescription& scene, const std::string& file);

}  // namespace equistream
