// The points that an eye's pixels see, and the planes they lie in.
#if defined(EQUISTREAM_WARP_POINTS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_POINTS_INL_H
#undef EQUISTREAM_WARP_POINTS_INL_H
#else
#define EQUISTREAM_WARP_POINTS_INL_H
#endif

#include "warp_positions-inl.h"

#include <limits>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// 1 / planar depth of a row of tiles and of a row of pixels on either side: linear in the pixel along a plane, 0 for a
/// miss, NaN for what is no distance and beyond the picture.
class InversePlanarRows {
public:
    explicit InversePlanarRows(const WarpJob& job)
        : job_(job), stride_((job.eye.camera.width + tile_width) / tile_width * tile_width + 2 * tile_width),
          rows_(std::size_t(stride_) * (tile_height + 2), std::numeric_limits<float>::quiet_NaN()) {}

    /// Rows y - 1 to y + tile_height; of the tiles before, when those were the ones above, nothing is computed anew.
    void prepare(int y) {
        int known = 0;
        if (y == next_y_) {
            std::copy(rows_.end() - 2 * stride_, rows_.end(), rows_.begin());
            known = 2;
        }
        for (int row = known; row < tile_height + 2; ++row)
            prepare_row(y + row - 1, rows_.data() + row * stride_ + tile_width);
        next_y_ = y + tile_height;
    }
    /// Of a pixel of the tiles, or of one beside them; `row` counts from the tiles' first.
    const float* at(int x, int row) const { return rows_.data() + (row + 1) * stride_ + tile_width + x; }
    int stride() const { return stride_; }

private:
    void prepare_row(int y, float* to) const {
        const int width = job_.eye.camera.width;
        if (y < 0 || y >= job_.eye.camera.height) {
            std::fill_n(to, width, std::numeric_limits<float>::quiet_NaN());
            return;
        }
        const float* from = job_.eye.depth_m.row(y);
        const float inverse_focal = 1 / job_.rays.focal_px();
        const float b = (float(y) - job_.rays.centre_y()) * inverse_focal;
        int x = 0;
        for (; x + lanes <= width; x += lanes) {
            const Floats a = (columns_from(x) - all(job_.rays.centre_x())) * all(inverse_focal);
            const Floats depth = hn::LoadU(float_tag, from + x);
            const Floats inverse = hn::Sqrt(hn::MulAdd(a, a, all(1 + b * b))) / depth;
            const Floats none = all(std::numeric_limits<float>::quiet_NaN());
            hn::StoreU(hn::IfThenElse(depth > all(0.0f), inverse, none), float_tag, to + x);
        }
        for (; x < width; ++x)
            to[x] = from[x] > 0 ? job_.rays.length(x, y) / from[x] : std::numeric_limits<float>::quiet_NaN();
    }

    const WarpJob& job_;
    int stride_;
    std::vector<float> rows_;
    int next_y_ = -1;
};

/// Differences to the neighbours on either side; NaN where there is none.
struct SlopePair {
    Floats before, after;
};

/// The larger product of a factor with either slope; NaN only where both are.
HWY_INLINE Floats max_product(const SlopePair& slopes, Floats factor) {
    const Floats p = slopes.before * factor, q = slopes.after * factor;
    return hn::IfThenElse(hn::Or(p > q, hn::IsNaN(q)), p, q);
}

/// The smaller slope; 0 where there is none.
HWY_INLINE Floats believed(const SlopePair& slopes) {
    const FloatMask first = hn::Or(hn::Abs(slopes.before) <= hn::Abs(slopes.after), hn::IsNaN(slopes.after));
    const Floats slope = hn::IfThenElse(first, slopes.before, slopes.after);
    return hn::IfThenElseZero(hn::Not(hn::IsNaN(slope)), slope);
}

/// What an eye's pixels see: points, and the slopes of the surface there.
struct SeenPoints {
    Floats x, y;            ///< indices of the pixels
    Floats inverse_planar;  ///< 1 / m
    SlopePair across, down;
    Vectors direction;  ///< from the source's centre, its length the point's distance times `inverse_planar`
    Floats length;
};

HWY_INLINE SeenPoints seen_points(const WarpJob& job, const InversePlanarRows& rows, const Tile& tile, int i, int row) {
    SeenPoints s;
    s.x = columns_from(tile.x + i);
    s.y = all(float(tile.y + row));
    const float* at = rows.at(tile.x + i, row);
    s.inverse_planar = hn::LoadU(float_tag, at);
    s.across = {s.inverse_planar - hn::LoadU(float_tag, at - 1), hn::LoadU(float_tag, at + 1) - s.inverse_planar};
    s.down = {s.inverse_planar - hn::LoadU(float_tag, at - rows.stride()),
              hn::LoadU(float_tag, at + rows.stride()) - s.inverse_planar};
    // The point over its planar depth: at infinity only the direction is left, with no case of its own.
    const Vectors r = ray(job.rays, s.x, s.y);
    const glm::vec3 eye = job.rays.eye();
    s.direction = {hn::MulAdd(all(eye.x), s.inverse_planar, r.x), hn::MulAdd(all(eye.y), s.inverse_planar, r.y),
                   hn::MulAdd(all(eye.z), s.inverse_planar, r.z)};
    s.length = hn::Sqrt(dot(s.direction, s.direction));
    return s;
}

/// Whether the source lies behind the surface's plane, whichever neighbours that is laid through (eye_rays.h).
HWY_INLINE FloatMask shows_back(const EyeRays& rays, const SeenPoints& s) {
    const glm::vec3 c = rays.eye_own_axes();
    const Floats by_slope_x = hn::MulAdd(all(c.z), s.x - all(rays.centre_x()), all(c.x * rays.focal_px()));
    const Floats by_slope_y = hn::MulAdd(all(c.z), s.y - all(rays.centre_y()), all(-c.y * rays.focal_px()));
    const Floats largest = hn::NegMulAdd(all(c.z), s.inverse_planar, all(1.0f)) + max_product(s.across, by_slope_x) +
                           max_product(s.down, by_slope_y);
    return largest < all(0.0f);
}

/// The plane 1 / r(q) = m . q of distances from the source's centre (eye_rays.h).
HWY_INLINE Vectors inverse_distance_gradient(const EyeRays& rays, const SeenPoints& s) {
    const Floats slope_x = believed(s.across), slope_y = believed(s.down);
    const Floats nx = slope_x * all(rays.focal_px());
    const Floats ny = hn::Neg(slope_y * all(rays.focal_px()));
    const Floats nz = hn::MulAdd(slope_x, s.x - all(rays.centre_x()),
                                 hn::MulSub(slope_y, s.y - all(rays.centre_y()), s.inverse_planar));
    const glm::mat3& turn = rays.source_from_eye();
    const auto turned = [&](int i) HWY_ATTR {
        return hn::MulAdd(all(turn[0][i]), nx, hn::MulAdd(all(turn[1][i]), ny, all(turn[2][i]) * nz));
    };
    const Vectors m{turned(0), turned(1), turned(2)};
    const glm::vec3 eye = rays.eye();
    const Floats scale = all(1.0f) / (all(1.0f) + dot(m, {all(eye.x), all(eye.y), all(eye.z)}));
    return {m.x * scale, m.y * scale, m.z * scale};
}

/// Where a tile's pixels take their colours from, by the depth of what each sees (warp_surface_kernels.cpp).
void map_surface(const WarpJob& job, const InversePlanarRows& rows, Tile& tile);

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
