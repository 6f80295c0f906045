// Vectors that the loops of resample.h are made of, up to 16 pixels at once, and where an eye's pixels fall among the
// source's samples, each on its own. Included once for each instruction set.
#if defined(EQUISTREAM_WARP_POSITIONS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_POSITIONS_INL_H
#undef EQUISTREAM_WARP_POSITIONS_INL_H
#else
#define EQUISTREAM_WARP_POSITIONS_INL_H
#endif

#include "resample.h"

#include <hwy/cache_control.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, tile_width>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using FloatMask = hn::Mask<FloatTag>;
using IntMask = hn::Mask<IntTag>;

constexpr FloatTag float_tag;
constexpr IntTag int_tag;
constexpr int lanes = int(hn::MaxLanes(FloatTag()));

HWY_INLINE Floats all(float value) {
    return hn::Set(float_tag, value);
}
HWY_INLINE Ints all(int value) {
    return hn::Set(int_tag, value);
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#include <plugin/formulas/vectors-inl.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

struct Vectors {
    Floats x, y, z;
};

HWY_INLINE Floats dot(const Vectors& a, const Vectors& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, a.z * b.z));
}

/// What tiles to the right will read of a plane, from where this one's rows end, is asked for now: the lower samples,
/// as the topmost upper ones were the tiles' above.
HWY_INLINE void ask_ahead(const std::uint8_t* base, std::ptrdiff_t row_bytes, const std::int32_t* offsets) {
    constexpr int ahead = 128;  // two lines of the cache
    for (int row = 1; row < tile_height; row += 2)
        hwy::Prefetch(base + row_bytes + offsets[(row + 1) * tile_width - 1] + ahead);
}

/// 8 bytes from each of the offsets, one behind the other.
template <typename Tag>
HWY_INLINE hn::Vec<Tag> load_eights(Tag tag, const std::uint8_t* base, const std::int32_t* offsets) {
    constexpr std::size_t groups = hn::MaxLanes(Tag()) / 8;
    if constexpr (groups == 1) {
        return hn::LoadU(tag, base + offsets[0]);
    } else {
        const hn::Half<Tag> half;
        return hn::Combine(tag, load_eights(half, base, offsets + groups / 2), load_eights(half, base, offsets));
    }
}

/// w0 p0 + w1 p1 of neighbouring bytes, weights from 0 to 128 and samples from -128 to 127.
template <typename Tag>
HWY_INLINE hn::Vec<hn::RepartitionToWide<hn::RebindToSigned<Tag>>> weighted_pairs(Tag, hn::Vec<Tag> weights,
                                                                                  hn::Vec<Tag> samples) {
#if HWY_TARGET == HWY_AVX3
    return hwy::HWY_NAMESPACE::Vec512<std::int16_t>{_mm512_maddubs_epi16(weights.raw, samples.raw)};
#elif HWY_TARGET == HWY_AVX2
    return hwy::HWY_NAMESPACE::Vec256<std::int16_t>{_mm256_maddubs_epi16(weights.raw, samples.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
    return hwy::HWY_NAMESPACE::Vec128<std::int16_t>{_mm_maddubs_epi16(weights.raw, samples.raw)};
#else
    const hn::RepartitionToWide<hn::RebindToSigned<Tag>> wide;
    const hn::RebindToUnsigned<decltype(wide)> unsigned_wide;
    const auto s = hn::BitCast(wide, samples);
    const auto even = hn::And(hn::BitCast(wide, weights), hn::Set(wide, 0xff));
    const auto odd = hn::BitCast(wide, hn::ShiftRight<8>(hn::BitCast(unsigned_wide, weights)));
    return even * hn::ShiftRight<8>(hn::ShiftLeft<8>(s)) + odd * hn::ShiftRight<8>(s);
#endif
}

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
    const glm::vec3 c = rays.corner(), r = rays.right(), d = rays.down();
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
