#include "push_pull_pass.h"

#include "background_depth.h"

#include <equistream/bound.h>

#include <algorithm>
#include <cmath>

namespace equistream {

/// The main source from the eye, in the eye's axes; 0 where nobody has said where that is.
glm::dvec3 PushPullPass::towards_source(const EyeView& eye) const {
    if (inputs_.main == nullptr)
        return glm::dvec3(0);
    return glm::conjugate(eye.pose.orientation) * (inputs_.main->pose.position_m - eye.pose.position_m);
}

std::int64_t PushPullPass::fill(const EyeView& eye, EyePicture& picture, Gaps& gaps) const {
    if (gaps.empty())
        return 0;
    std::unique_ptr<Workspace> work = pool_.acquire();
    const glm::dvec3 source = towards_source(eye);
    SurfaceDepths depths;
    const double box_radius_m = inputs_.main == nullptr ? 0 : inputs_.main->box_radius_m;
    depths.box_radius_m = float(std::max(box_radius_m, glm::length(source)));
    depths.tolerance = float(std::sin(error_budget_rad(eye.camera.focal_px(), inputs_.error_budget_px)));
    if (eye.depth_m.data != nullptr) {
        depths.known_m = depths.gap_m = eye.depth_m;
    } else if (!picture.depth_m.empty()) {
        find_background(eye, picture, gaps, source, work->background_m);
        depths.known_m = picture.depth_m.view();
        depths.gap_m = work->background_m.view();
    }
    const std::int64_t filled = work->pyramid.run(depths, gaps, picture);
    if (eye.depth_m.data == nullptr && !picture.depth_m.empty())
        for (const GapSpan& span : gaps.spans())
            std::copy_n(work->background_m.pixel(span.begin, span.y), span.end - span.begin,
                        picture.depth_m.pixel(span.begin, span.y));
    pool_.release(std::move(work));
    gaps.narrow(picture.origin.view());
    return filled;
}

std::unique_ptr<FillPass> make_push_pull_pass() {
    return std::make_unique<PushPullPass>();
}

}  // namespace equistream
