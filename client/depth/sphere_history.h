#pragma once
/// The depth of one sphere as it was last cast, and what of it holds from another position. Internal to RayDepth.
#include "carried_tiles.h"
#include "cast_mask.h"
#include "surface_planes.h"

#include <equistream/camera.h>
#include <equistream/image.h>

#include <span>
#include <vector>

namespace equistream {

/// What sizes the error: B and the largest error in w.
struct ReuseBound {
    double box_radius_m, error;
};

class SphereHistory {
public:
    /// `planes` is borrowed: what the numbers of set_cast mean.
    SphereHistory(const EquirectCamera& camera, const ReuseBound& bound, const SurfacePlanes& planes);
    SphereHistory(const SphereHistory&) = delete;
    SphereHistory& operator=(const SphereHistory&) = delete;

    const EquirectCamera& camera() const { return camera_; }
    const Pose& pose() const { return pose_; }

    /// Carries `last`, of the same camera and orientation, to `pose`: fills `depth_m` and this where that is within the
    /// bound and sets `cast` to 1 elsewhere. Pixels that movers cover, now or then, are cast. False where the way is
    /// too long for anything: then all are cast.
    bool carry(const SphereHistory& last, const Pose& pose, std::span<const MoverBall> movers_now, CastMask& cast,
               ImageView<float> depth_m);
    /// A pixel was cast. Any number of threads, each its own pixels.
    void set_cast(int x, int y, std::int32_t plane) { seen_.row(y)[x] = plane; }
    /// After what `carry` left was cast: pixels of rows next to the poles, slivers of which one column in four is cast;
    /// those between are as their nearest neighbour.
    void fill_poles(CastMask& cast, ImageView<float> depth_m);
    /// All pixels are there: ready to be carried on.
    void finish(const Pose& pose, std::span<const MoverBall> movers, ImageView<const float> depth_m);

private:
    SphereWarp warp_from(const Pose& pose) const;
    void warp_tiles(const SphereWarp& warp, const SphereRow& row, const NewRow& now,
                    const std::vector<std::int32_t>& planes) const;
    bool mark_edges(const SphereWarp& warp, CastMask& cast) const;

    /// An edge of depth: where, and the inverse distances it lies between.
    struct Edge {
        int x;
        float lowest_inverse_m, highest_inverse_m;
    };

    EquirectCamera camera_;
    ReuseBound bound_;
    const SurfacePlanes* planes_;
    Pose pose_;
    std::vector<MoverBall> movers_;
    SphereAngles angles_;
    CarriedTiles tiles_;
    PlaneNumbers seen_;
    Cells cells_;
    std::vector<std::vector<Edge>> edges_;  ///< by row
    bool polar_cast_[2] = {true, true};     ///< rows next to the upper, the lower pole are cast in part
};

}  // namespace equistream
