// Where an eye's pixels fall among the source's samples, each on its own.
#if defined(EQUISTREAM_WARP_POSITIONS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_POSITIONS_INL_H
#undef EQUISTREAM_WARP_POSITIONS_INL_H
#else
#define EQUISTREAM_WARP_POSITIONS_INL_H
#endif

#include "warp_numbers-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// Where each pixel of a tile takes its colour; the tile's pixels lie row by row.
struct Tile {
    int x = 0, y = 0, columns = tile_width, rows = tile_height;  ///< what of it lies in the picture
    bool regular = false;  ///< every pixel counts and has all four samples inside the source
    /// Position in 1/128 of a sample, from the first sample's middle.
    alignas(64) std::int32_t u[tile_pixels], v[tile_pixels];
    /// Bit k: sample k (right: 1, below: 2) shows what the eye sees. 0: a gap.
    alignas(64) std::int32_t keep[tile_pixels];
};

struct Positions {
    Floats u, v;
};

/// The source's image of directions in its frame.
HWY_INLINE Positions project(const SourceGrid& grid, const Vectors& d) {
    if (grid.sphere)
        return {formulas::sphere_column(d.x, d.z, grid.middle, grid.columns_per_radian, grid.half_width),
                formulas::sphere_row(d.x, d.y, d.z, grid.top, grid.rows_per_radian)};
    return {formulas::flat_column(d.x, d.z, grid.focal_px, grid.half_width),
            formulas::flat_row(d.y, d.z, grid.focal_px, grid.half_height)};
}

/// Whether they lie in the picture; false for NaN.
HWY_INLINE FloatMask inside(const SourceGrid& grid, const Positions& p) {
    return hn::And(formulas::is_within(p.u, float(grid.width)), formulas::is_within(p.v, float(grid.height)));
}

/// The samples nearest to some positions; any of the picture's where it does not cover them.
struct Nearest {
    Ints column, row;
    FloatMask covered;
};

HWY_INLINE Nearest nearest_sample(const SourceGrid& grid, const Positions& p) {
    const FloatMask covered = inside(grid, p);
    const auto index = [&](Floats position, int size) HWY_ATTR {
        return hn::Min(hn::Max(hn::ConvertTo(int_tag, hn::IfThenElseZero(covered, position)), all(0)), all(size - 1));
    };
    return {index(p.u, grid.width), index(p.v, grid.height), covered};
}
HWY_INLINE Nearest nearest_sample(const SourceGrid& grid, const Vectors& direction) {
    return nearest_sample(grid, project(grid, direction));
}

/// Of a plane with one channel and the source's size.
HWY_INLINE Floats value_at(const ImageView<const float>& plane, const Nearest& n) {
    return hn::GatherIndex(float_tag, plane.data, n.row * all(int(plane.row_stride)) + n.column);
}

/// From the first sample's middle.
HWY_INLINE Ints fixed_point(Floats position) {
    return hn::NearestInt(hn::MulAdd(position, all(float(position_one)), all(-0.5f * position_one)));
}

HWY_INLINE Vectors ray(const EyeRays& rays, Floats x, Floats y) {
    const Vec3f c = rays.corner(), r = rays.right(), d = rays.down();
    return {hn::MulAdd(x, all(r.x), hn::MulAdd(y, all(d.x), all(c.x))),
            hn::MulAdd(x, all(r.y), hn::MulAdd(y, all(d.y), all(c.y))),
            hn::MulAdd(x, all(r.z), hn::MulAdd(y, all(d.z), all(c.z)))};
}

HWY_INLINE Floats columns_from(int x) {
    return hn::Iota(float_tag, float(x));
}

/// Every pixel of a tile on its own.
HWY_INLINE void map_exactly(const WarpJob& job, Tile& tile) {
    tile.regular = false;
    for (int row = 0; row < tile_height; ++row)
        for (int i = 0; i < tile_width; i += lanes) {
            const Positions p = project(job.grid, ray(job.rays, columns_from(tile.x + i), all(float(tile.y + row))));
            const int at = row * tile_width + i;
            const FloatMask covered = inside(job.grid, p);
            hn::Store(fixed_point(hn::IfThenElseZero(covered, p.u)), int_tag, tile.u + at);
            hn::Store(fixed_point(hn::IfThenElseZero(covered, p.v)), int_tag, tile.v + at);
            hn::Store(hn::IfThenElseZero(hn::RebindMask(int_tag, covered), all(15)), int_tag, tile.keep + at);
        }
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
