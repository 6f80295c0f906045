#pragma once
/// A source's depth as a surface: a lattice of points (q, 1/r), one a pixel, in blocks that fit a core's cache. Two
/// neighbours are joined where depth_agreement.h calls them one surface; engines draw what is joined and cut the rest.
///
/// Points are homogeneous: (q, k) stands for q / k, so that k = 0 is infinity, means of points lie on the segment
/// between them, and a point on a plane m . X = 1 has k = m . q.
#include "eye_rays.h"
#include "resample.h"
#include "view.h"

#include <equistream/camera.h>
#include <equistream/depth_agreement.h>
#include <equistream/image.h>

#include <array>
#include <cstdint>
#include <vector>

namespace equistream {

/// In the source's camera frame.
struct LatticePoint {
    glm::vec3 q;  ///< towards the point; of length 1 where it is a sample's
    float k = 0;  ///< length of q over the distance; NaN where nothing is known
};

/// The samples of one block and those beside it: what joins the points that its last cells end on lies two beyond them.
/// Large: one a thread.
struct LatticeBlock {
    static constexpr int side = 32;
    static constexpr int before = 2, after = 3;
    static constexpr int stride = before + side + after;

    int x0 = 0, y0 = 0;         ///< lattice coordinates of its first point
    int columns = 0, rows = 0;  ///< cells from there on, at most `side` each
    std::array<float, stride * stride> qx{}, qy{}, qz{}, k{};

    /// Of the block's own coordinates, from -before to side + after - 1.
    static constexpr int at(int x, int y) { return (y + before) * stride + x + before; }
    LatticePoint point(int x, int y) const {
        const int i = at(x, y);
        return {{qx[i], qy[i], qz[i]}, k[i]};
    }
};

/// Of each point of a block, whether it is joined to its right and to its lower neighbour; true for points from
/// (-1, -1) to (side, side).
struct JoinedPoints {
    std::array<std::uint8_t, LatticeBlock::stride * LatticeBlock::stride> right{}, down{};
};
void find_joined(const LatticeBlock& block, const DepthAgreement& same_surface, JoinedPoints& joined);

/// Coordinates: point (i, j) is the centre of pixel (i, j). A sphere closes on itself: columns go round, and row -1 is
/// row 0 on the other side of the pole. Where a picture ends, points -1, W and H lie on its edge, half a pixel out.
class SourceLattice {
public:
    /// What a block holds with the points that its cells end on, and the samples beside those.
    struct Summary {
        float nearest_inverse_m = 0;           ///< largest k that its cells may have; 0 where nothing is known
        float farthest_inverse_m = 0;          ///< smallest k that they may have
        glm::vec3 axis;                        ///< the middle of its directions
        float cos_radius = 1, sin_radius = 0;  ///< of the cone around it that holds them all
    };

    /// Borrows `depth_m` for as long as it is used. Reads all of it, on all cores.
    SourceLattice(const Camera& camera, ImageView<const float> depth_m);

    int width() const { return depth_m_.width; }
    int height() const { return depth_m_.height; }
    bool closes() const { return grid_.closes; }
    /// The first cell's lattice coordinates: its column is -1 where the picture does not close.
    int first_column() const { return closes() ? 0 : -1; }
    static constexpr int first_row() { return -1; }
    int block_columns() const { return block_columns_; }
    int block_rows() const { return block_rows_; }
    const Summary& summary(int block_x, int block_y) const {
        return summaries_[std::size_t(block_y) * std::size_t(block_columns_) + std::size_t(block_x)];
    }
    void load(int block_x, int block_y, LatticeBlock& block) const;

    /// Any lattice point; (q, NaN) beyond the picture.
    LatticePoint point(int x, int y) const;
    /// Whether it is a pixel's centre, once round a sphere or over its poles; not beyond the picture, nor on its edge.
    bool is_sample(int x, int y) const {
        wrap(x, y);
        return x >= 0 && y >= 0 && x < width() && y < height();
    }
    glm::vec3 direction(int x, int y) const;
    /// 1 / distance of a sample: 0 for a miss, NaN for what is no distance.
    static float inverse_of(float distance_m) { return distance_m > 0 ? 1 / distance_m : std::nanf(""); }

private:
    Summary summarise(int block_x, int block_y) const;
    float edge_inverse(int x, int y) const;
    /// Brings lattice coordinates of a sphere back into the picture.
    void wrap(int& x, int& y) const;
    glm::vec3 direction_of_tables(int column, int row) const;

    ImageView<const float> depth_m_;
    SourceGrid grid_;
    int block_columns_ = 0, block_rows_ = 0;
    LatticeAngles angles_;
    std::vector<Summary> summaries_;
};

// From a source's lattice to an eye's pixels, in single precision.

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
    glm::vec3 homogeneous(const LatticePoint& p) const {
        const glm::vec3 e = p.q + eye_ * -p.k;
        return {dot(x_, e), dot(y_, e), dot(forward_, e)};
    }
    EyePoint project(const LatticePoint& p) const {
        const glm::vec3 h = homogeneous(p);
        const float scale = 1 / h.z;
        return {h.x * scale, h.y * scale, p.k * scale, h.z > 0};
    }
    void project(const LatticeBlock& block, ProjectedBlock& out) const;
    int width() const { return width_; }
    int height() const { return height_; }

private:
    glm::vec3 x_, y_, forward_, eye_;
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
        glm::vec3 inwards;  ///< unit
        float at_eye = 0;   ///< inwards . eye
    };
    std::array<Plane, 4> planes_;
};

}  // namespace equistream
