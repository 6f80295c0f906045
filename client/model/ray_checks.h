#pragma once
/// What rays from the head boxes see: of a scene's triangles, and of a model in the scene's place.
#include "client_model.h"
#include "head_boxes.h"

#include <scenes/embree/bvh.h>

#include <vector>

namespace equistream {

// Which triangles an eye in a head box can see, by casting rays; never less than the rays hit.

/// By instance and triangle of its mesh: 1 where seen.
using SeenTriangles = std::vector<std::vector<std::uint8_t>>;

/// Whole spheres of rays from eyes all along the path find what is seen at a glance; triangles they miss, small ones
/// and those that peep out of narrow gaps, are then aimed at one by one.
SeenTriangles find_seen(const SceneModel& model, const Bvh& bvh, const HeadBoxes& boxes, std::int64_t rays,
                        std::uint64_t seed);

/// Adds to what is seen of one instance every triangle that shares a point with a seen one.
void add_neighbours(const Mesh& mesh, std::vector<std::uint8_t>& seen);

// A model against the scene it stands for, by rays from random eyes in the head boxes into random directions.

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
