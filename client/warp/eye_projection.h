#pragma once
/// From a source's lattice to an eye's pixels, in single precision.
#include "source_lattice.h"

#include "view.h"

#include <array>

namespace equistream {

/// Where a point falls in the eye's picture: pixel centres are whole numbers here. `inverse_planar` is 1 / planar
/// depth, linear in (x, y) along a plane. Only what lies before the eye (`before`) has such a place.
struct EyePoint {
    float x = 0, y = 0, inverse_planar = 0;
    bool before = false;
};

/// All points of a block; `forward` is positive for those before the eye, the others are wrong where it is not.
struct ProjectedBlock {
    std::array<float, LatticeBlock::stride * LatticeBlock::stride> x{}, y{}, inverse_planar{}, forward{};

    EyePoint at(int i) const { return {x[i], y[i], inverse_planar[i], forward[i] > 0}; }
};

/// The part of an eye's picture that one thread draws, in whole pixels; ends are excluded.
struct PixelBox {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

class EyeProjection {
public:
    EyeProjection(const PerspectiveCamera& camera, const Pose& eye, const Pose& source);

    /// Homogeneous: (forward, x * forward, y * forward), all linear in the point.
    Vec3f homogeneous(const LatticePoint& p) const {
        const Vec3f e = p.q + eye_ * -p.k;
        return {dot(x_, e), dot(y_, e), dot(forward_, e)};
    }
    EyePoint project(const LatticePoint& p) const {
        const Vec3f h = homogeneous(p);
        const float scale = 1 / h.z;
        return {h.x * scale, h.y * scale, p.k * scale, h.z > 0};
    }
    void project(const LatticeBlock& block, ProjectedBlock& out) const;
    /// The eye in the source's frame, metres.
    Vec3f eye() const { return eye_; }
    float distance_m() const { return std::sqrt(dot(eye_, eye_)); }
    int width() const { return width_; }
    int height() const { return height_; }

private:
    Vec3f x_, y_, forward_, eye_;
    int width_ = 0, height_ = 0;
};

/// What an eye sees through a box of its pixels, as four planes through the eye.
class SeenThrough {
public:
    SeenThrough(const PerspectiveCamera& camera, const Pose& eye, const Pose& source, PixelBox box);

    /// False only if no point of the block falls into the box.
    bool may_show(const SourceLattice::Summary& block) const;

private:
    struct Plane {
        Vec3f inwards;     ///< unit
        float at_eye = 0;  ///< inwards . eye
    };
    std::array<Plane, 4> planes_;
};

}  // namespace equistream
