#pragma once
/// A model against the scene it stands for, by rays from random eyes in the head boxes into random directions.
#include "client_model.h"
#include "head_boxes.h"

#include <scenes/embree/bvh.h>

#include <vector>

namespace equistream {

/// Where a ray failed, on both sides; either may have hit nothing.
struct FailedRay {
    HitId scene, model;
};

struct CheckSettings {
    double error_rad = 0, silhouette_rad = 0;
    std::int64_t rays = 0;
    std::uint64_t seed = 0;
};

/// A ray keeps the bound if both sides are hit at distances whose w (bound.h) differs by at most error_rad. One that
/// does not is at an edge if a ray of the scene no more than silhouette_rad beside it hits what the model shows, or the
/// other way round. Else it fails. Rays that hit something inside the head box are not covered by the bound: there the
/// distances must be equal to within a thousandth.
RayCheck check_by_rays(const Bvh& scene, const Bvh& model, const HeadBoxes& boxes, const CheckSettings& settings,
                       std::vector<FailedRay>& failed);

}  // namespace equistream
