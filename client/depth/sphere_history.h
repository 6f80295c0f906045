#pragma once
/// The depth of one sphere as it was last cast, and what of it holds from another position. Internal to RayDepth.
#include "sphere_warp.h"
#include "surface_planes.h"

#include <equistream/camera.h>
#include <equistream/image.h>

#include <algorithm>
#include <cstring>
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

    /// The marked pixels of a square of 4 by 4, a bit each, row by row; those beyond the picture are not marked.
    unsigned square(int x, int y) const {
        unsigned bits = 0;
        for (int j = 0; j < std::min(4, height_ - y); ++j) {
            std::uint32_t four;
            std::memcpy(&four, bytes_.data() + std::ptrdiff_t(y + j) * stride_ + x, sizeof four);
            if (four != 0)
                for (int i = 0; i < std::min(4, width_ - x); ++i)
                    bits |= unsigned(four >> 8 * i & 1) << (4 * j + i);
        }
        return bits;
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
    /// `planes` is borrowed: what the numbers of set_cast mean.
    SphereHistory(const EquirectCamera& camera, const ReuseBound& bound, const SurfacePlanes& planes);

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
    SphereRow row_at(int y) const;
    void set_world(const glm::dquat& orientation);
    bool is_polar(int y) const;
    std::int32_t& tile(int column, int row) { return tiles_[std::size_t(row) * std::size_t(tile_columns_) + column]; }
    std::int32_t tile(int column, int row) const {
        return tiles_[std::size_t(row) * std::size_t(tile_columns_) + column];
    }
    float met(const SphereWarp& warp, std::int32_t plane, int x, int y) const;
    std::int32_t plane_still_seen(const SphereWarp& warp, int tile_column, int tile_row) const;
    std::int32_t cap_plane(const SphereWarp& warp, bool top) const;
    void warp_tiles(const SphereWarp& warp, const SphereRow& row, const NewRow& now,
                    const std::vector<std::int32_t>& planes) const;
    bool mark_edges(const SphereWarp& warp, CastMask& cast) const;
    void mark_ball(const MoverBall& ball, const Pose& pose, CastMask& cast) const;

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
    PlaneNumbers seen_;
    Cells cells_;
    int tile_columns_, tile_rows_;
    std::vector<std::int32_t> tiles_;       ///< the plane that all of a tile sees, or `mixed`
    std::vector<std::vector<Edge>> edges_;  ///< by row
    std::vector<float> sin_longitude_, cos_longitude_, sin_latitude_, cos_latitude_;
    std::vector<float> column_world_[3];  ///< as SphereWarp has them
    glm::dvec3 up_world_{0, 1, 0};
    bool polar_cast_[2] = {true, true};  ///< rows next to the upper, the lower pole are cast in part
};

}  // namespace equistream
