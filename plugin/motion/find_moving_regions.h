#pragma once
/// Finds what of a picture moves by itself, as rigid bodies: the camera's movement is taken out of the motion AOV, what
/// is left is fitted with twists (object_motion.h). One twist for each object where ids tell objects apart, else for
/// each connected piece of what moves; where none fits (a body that bends), the piece is halved until its parts do.
#include <equistream/bound.h>
#include <equistream/camera.h>
#include <equistream/image.h>
#include <equistream/object_motion.h>

#include <cstdint>
#include <vector>

namespace equistream {

/// A frame before or behind, and where things are in it.
struct MotionNeighbour {
    Pose pose;                           ///< of its camera
    double seconds = 0;                  ///< from this picture to it: below 0 for the one before
    ImageView<const float> motion_px{};  ///< 2 channels, to where the same point is in it
};

/// One picture's planes, of its size; borrowed.
struct MotionPlanes {
    Camera camera;
    Pose pose;
    ImageView<const float> depth_m{};  ///< radial, +inf for a miss
    /// One, or both: then how motion changes is known too.
    std::vector<MotionNeighbour> neighbours;
    ImageView<const std::uint32_t> object_id{};  ///< or empty
};

struct MotionSearch {
    double error_rad = error_budget_rad(default_focal_length_px);  ///< after `horizon_s`
    double horizon_s = extrapolation_horizon_s;
    /// Regions with less are not worth their bytes.
    int min_pixels = 4;
};

struct FoundMotion {
    std::vector<MovingRegion> regions;  ///< the largest first; at most max_moving_regions
    std::int64_t moving_pixels = 0;     ///< that move by more than error_rad in horizon_s
    /// Over these, from here to the neighbours and in proportion for horizon_s: what the movement itself is, and what
    /// is left of it once regions are extrapolated; of pixels in no region all of it is.
    double mean_motion_rad = 0, mean_error_rad = 0, p95_error_rad = 0;
};

FoundMotion find_moving_regions(const MotionPlanes& planes, const MotionSearch& search = {});

}  // namespace equistream
