#include "decisions.h"

#include <client/receive/received_view.h>
#include <client/stages/stages.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>

namespace equistream {

TrackRoles unneeded_roles(const PipelineChoice& choice) {
    const bool with_depth = find_engine(choice.engine).needs.any();
    TrackRoles needed;
    const auto need = [&](TrackRole role, bool is_needed) { needed[std::size_t(role)] = is_needed; };
    need(TrackRole::main, true);
    bool looks_points_up = false;
    for (const FillStage* stage : parse_fills(choice.fill)) {
        if (with_depth || !stage->needs_depth)
            needed |= stage->reads;
        looks_points_up = looks_points_up || stage->make()->wants_depth();
    }
    // All others are looked up by the eye's depth, mirrors too.
    need(TrackRole::depth, with_depth && !is_cast(choice.depth));
    need(TrackRole::reflections, with_depth && (choice.mirrors || looks_points_up));
    return ~needed;
}

bool counts_as_earlier(double earlier_s, double shown_s) {
    constexpr double max_age_s = 1;
    return earlier_s < shown_s && shown_s - earlier_s <= max_age_s;
}

ReliabilityOptions confidence_options(const FrameInfo& main, bool by_frames_depth, MirrorTreatment mirrors) {
    return confidence_options(by_frames_depth ? depth_tolerance_w(main.depth_code) : 0, coding_loss_of(main), mirrors);
}

ReliabilityOptions confidence_options(double depth_tolerance_w, const std::optional<CodingLoss>& coding_loss,
                                      MirrorTreatment mirrors) {
    return {.depth_tolerance_w = depth_tolerance_w,
            .coding_loss = coding_loss,
            .specular_reworked = mirrors != MirrorTreatment::surface};
}

bool leaves_head_box(const Pose& eye, const FrameInfo& source) {
    constexpr double rounding_m = 1e-6;  // eyes at rest lie on the ball
    return glm::distance(eye.position_m, source.camera_pose.position_m) > head_box_radius(source) + rounding_m;
}

void require_tagged_size(const ReceivedPicture& picture, const std::string& source) {
    const int width = width_of(picture.info.camera), height = height_of(picture.info.camera);
    if (picture.width() != width || picture.height() != height)
        throw WorkError(expected_found(source + ": frame " + std::to_string(picture.info.index),
                                       std::to_string(width) + "x" + std::to_string(height) + " as its tag says",
                                       std::to_string(picture.width()) + "x" + std::to_string(picture.height())));
}

}  // namespace equistream
