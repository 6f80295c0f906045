#pragma once
/// What the pipeline decides of a frame, once for its CPU and its GPU back end. Pure functions.
#include <client/confidence/reliability.h>
#include <client/receive/receive.h>
#include <client/reflections/specular.h>
#include <client/warp/view.h>

#include <optional>
#include <string>
#include <string_view>

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

/// What confidence is told of the main picture. `by_frames_depth`: eyes are reprojected by the depth that came with the
/// frame, whose code may be off; else by depth that has no such error.
ReliabilityOptions confidence_options(const FrameInfo& main, bool by_frames_depth, MirrorTreatment mirrors);

/// The same of colours that went through this coding, and depth whose w may be off by so much.
ReliabilityOptions confidence_options(double depth_tolerance_w, const std::optional<CodingLoss>& coding_loss,
                                      MirrorTreatment mirrors);

/// Whether an eye is outside the head box that the source was rendered for.
bool leaves_head_box(const Pose& eye, const FrameInfo& source);

/// Throws WorkError where a picture has another size than its tag says. `source`: named in the message.
void require_tagged_size(const ReceivedPicture& picture, const std::string& source);

}  // namespace equistream
