#pragma once
/// The depth of one sphere as it was last cast, and what of it holds from another position. Internal to RayDepth.
#include "sphere_warp.h"

#include <equistream/camera.h>
#include <equistream/image.h>

#include <span>

namespace equistream {

/// A ball around a moving object, in the world.
struct MoverBall {
    glm::dvec3 centre_m;
    double radius_m;
};

/// What of a new frame has to be cast, a byte a pixel; rows have spare bytes for whole registers.
class CastMask {
public:
    /// All 0; memory is kept.
    void resize(int width, int height) {
        width_ = width;
        height_ = height;
        stride_ = width + 16;
        bytes_.assign(std::size_t(stride_) * std::size_t(height), 0);
    }
    std::uint8_t* row(int y) { return bytes_.data() + std::ptrdiff_t(y) * stride_; }
    void set_all(std::uint8_t value) { std::fill(bytes_.begin(), bytes_.end(), value); }

    /// The marked pixels of a square, row by row.
    template <typename Act>
    void each_in(int x, int y, int side, const Act& act) {
        for (int j = y; j < std::min(y + side, height_); ++j)
            for (int i = x; i < std::min(x + side, width_); ++i)
                if (row(j)[i] != 0)
                    act(i, j);
    }
    bool is_full(int x, int y, int side) {
        int marked = 0;
        each_in(x, y, side, [&](int, int) { ++marked; });
        return marked == side * side;
    }

private:
    int width_ = 0, height_ = 0, stride_ = 0;
    std::vector<std::uint8_t> bytes_;
};

/// What sizes the error: B and the largest error in w.
struct ReuseBound {
    double box_radius_m, error;
};

class SphereHistory {
public:
    SphereHistory(const EquirectCamera& camera, const ReuseBound& bound);

    const EquirectCamera& camera() const { return camera_; }
    const Pose& pose() const { return pose_; }

    /// Carries `last`, of the same camera and orientation, to `pose`: fills `depth_m` and this where that is within the
    /// bound and sets `cast` to 1 elsewhere. Pixels that movers cover, now or then, are cast. False where the way is
    /// too long for anything: then all are cast.
    bool carry(const SphereHistory& last, const Pose& pose, std::span<const MoverBall> movers_now, CastMask& cast,
               ImageView<float> depth_m);
    /// A pixel was cast. Any number of threads, each its own pixels.
    void set_cast(int x, int y, float distance_m) {
        inverse_m_.row(y)[x] = 1 / distance_m;  // 0 for a miss
        cost_.row(y)[x] = 0;
    }
    /// After what `carry` left was cast: pixels of rows next to the poles, slivers of which only some are cast.
    void fill_poles(ImageView<float> depth_m);
    /// All pixels are there: ready to be carried on.
    void finish(const Pose& pose, std::span<const MoverBall> movers);

private:
    SphereWarp warp_to(const Pose& pose) const;
    bool mark_edges(const SphereWarp& warp, CastMask& cast) const;
    void mark_ball(const MoverBall& ball, const Pose& pose, CastMask& cast) const;

    EquirectCamera camera_;
    ReuseBound bound_;
    Pose pose_;
    std::vector<MoverBall> movers_;
    PaddedPlane inverse_m_, cost_;
    std::vector<std::vector<EdgeCell>> edges_;  ///< by row
    std::vector<float> sin_longitude_, cos_longitude_, sin_latitude_, cos_latitude_;
};

}  // namespace equistream
