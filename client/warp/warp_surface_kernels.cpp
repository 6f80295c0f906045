// Whether the source saw the points that an eye's pixels see.
#include "resample.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "client/warp/warp_surface_kernels.cpp"
#include <hwy/foreach_target.h>

#include "hiding_surface-inl.h"
#include "warp_colour-inl.h"
#include "warp_fit-inl.h"
#include "warp_points-inl.h"

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// The four samples around each of some positions.
struct SamplesAround {
    alignas(64) std::int32_t x[4][lanes], y[4][lanes];
};

HWY_INLINE void samples_around(const SourceGrid& grid, Ints x0, Ints y0, SamplesAround& samples) {
    const IntMask whole =
        hn::And(hn::And(x0 > all(-1), y0 > all(-1)), hn::And(x0 < all(grid.width - 1), y0 < all(grid.height - 1)));
    for (int k = 0; k < 4; ++k) {
        hn::Store(x0 + all(k & 1), int_tag, samples.x[k]);
        hn::Store(y0 + all(k >> 1), int_tag, samples.y[k]);
    }
    if (hn::AllTrue(int_tag, whole))
        return;
    for (int k = 0; k < 4; ++k)
        for (int i = 0; i < lanes; ++i) {
            const Sample s = wrapped(grid, std::clamp(samples.x[k][i], -1, grid.width),
                                     std::clamp(samples.y[k][i], -1, grid.height));
            samples.x[k][i] = s.x;
            samples.y[k][i] = s.y;
        }
}

/// Distances at the four samples of some pixels, or what is made of those.
using Distances = std::array<Floats, 4>;

/// |w - w'| <= sin e of depth_agreement.h, both sides times some length over the distance: no division, and no case of
/// its own for infinity.
class ScaledClearance {
public:
    HWY_INLINE ScaledClearance(const DepthAgreement& agreement, Floats length, Floats over_distance)
        : over_distance_(over_distance),
          clearance_(hn::Max(length * all(equistream::formulas::min_clearance_share),
                             hn::NegMulAdd(all(agreement.box_radius_m), over_distance, length))),
          allowed_(clearance_ * all(agreement.tolerance / agreement.box_radius_m)) {}

    /// How far a sample lies behind, in the same scale.
    HWY_INLINE Floats behind(Floats clearance_sample) const {
        return hn::MulSub(clearance_sample, over_distance_, clearance_);
    }
    HWY_INLINE FloatMask same(Floats behind, Floats clearance_sample) const {
        return hn::And(hn::Abs(behind) <= allowed_ * clearance_sample, clearance_sample > all(0.0f));
    }
    /// Whether w, over B, is that of something nearer by a number of tolerances.
    HWY_INLINE FloatMask is_behind(Floats over_clearance, float tolerances) const {
        return hn::MulSub(over_clearance, clearance_, over_distance_) > allowed_ * all(tolerances);
    }
    HWY_INLINE Floats over_clearance() const { return over_distance_ / clearance_; }

private:
    Floats over_distance_, clearance_, allowed_;
};

/// 1 / distance along a plane at the four samples around some points: m . q, to the second order in the step from the
/// point, which is below a sample.
class PlaneAround {
public:
    HWY_INLINE PlaneAround(const WarpJob& job, const Vectors& m, const SeenPoints& s, Ints u, Ints v) {
        const Floats unit = all(1.0f) / s.length;
        const Vectors q{s.direction.x * unit, s.direction.y * unit, s.direction.z * unit};
        du_ = hn::ConvertTo(float_tag, hn::And(u, all(position_one - 1))) * all(-1.0f / position_one);
        dv_ = hn::ConvertTo(float_tag, hn::And(v, all(position_one - 1))) * all(-1.0f / position_one);
        here_ = dot(m, q);
        // Longitude turns about the vertical; latitude about the horizontal axis across q.
        const Floats level = hn::Sqrt(hn::MulAdd(q.x, q.x, q.z * q.z));
        const Floats over_level = all(1.0f) / hn::Max(level, all(1e-12f));
        const Floats along = hn::MulAdd(m.x, q.x, m.z * q.z) * over_level;
        const Floats aside = hn::MulSub(m.z, q.x, m.x * q.z) * over_level;
        const Floats column = all(1 / job.grid.columns_per_radian), row = all(-1 / job.grid.rows_per_radian);
        by_u_ = aside * level * column;
        by_v_ = hn::MulSub(m.y, level, along * q.y) * row;
        by_uu_ = all(-0.5f) * along * level * column * column;
        by_uv_ = hn::Neg(aside * q.y) * column * row;
        by_vv_ = all(-0.5f) * here_ * row * row;
    }
    /// Of the k-th sample.
    HWY_INLINE Floats at(int k) const {
        const Floats du = du_ + all(float(k & 1)), dv = dv_ + all(float(k >> 1));
        const Floats across = hn::MulAdd(by_uu_, du, hn::MulAdd(by_uv_, dv, by_u_));
        return hn::MulAdd(across, du, hn::MulAdd(hn::MulAdd(by_vv_, dv, by_v_), dv, here_));
    }

private:
    Floats du_, dv_, here_, by_u_, by_v_, by_uu_, by_uv_, by_vv_;
};

/// The same for perspective sources, where the samples' directions are at hand.
HWY_INLINE Floats plane_at(const SourceGrid& grid, const Vectors& m, Ints x, Ints y) {
    const Floats inverse_focal = all(1 / grid.focal_px);
    const Floats a = (hn::ConvertTo(float_tag, x) + all(0.5f - grid.half_width)) * inverse_focal;
    const Floats b = (all(grid.half_height - 0.5f) - hn::ConvertTo(float_tag, y)) * inverse_focal;
    const Floats length = hn::Sqrt(hn::MulAdd(a, a, hn::MulAdd(b, b, all(1.0f))));
    return (hn::MulAdd(m.x, a, m.y * b) - m.z) / length;
}

/// The samples that lie between the point's own distance and what its plane predicts for them, give or take; added to
/// those kept already.
HWY_INLINE Ints kept_along_slope(const WarpJob& job, const SeenPoints& s, Ints u, Ints v,
                                 const Distances& clearance_sample, const Distances& behind, Ints keep) {
    const Vectors gradient = inverse_distance_gradient(job.rays, s);
    const PlaneAround around(job, gradient, s, u, v);
    for (int k = 0; k < 4; ++k) {
        const Floats inverse = job.grid.sphere
                                   ? around.at(k)
                                   : plane_at(job.grid, gradient, hn::ShiftRight<position_bits>(u) + all(k & 1),
                                              hn::ShiftRight<position_bits>(v) + all(k >> 1));
        const ScaledClearance predicted(job.agreement, all(1.0f), hn::Max(inverse, all(1 / far_distance_m)));
        const Floats behind_predicted = predicted.behind(clearance_sample[k]);
        const FloatMask between = hn::And(behind[k] * behind_predicted<all(0.0f), clearance_sample[k]> all(0.0f));
        const FloatMask agrees = hn::Or(between, predicted.same(behind_predicted, clearance_sample[k]));
        keep = hn::Or(keep, hn::IfThenElseZero(hn::RebindMask(int_tag, agrees), all(1 << k)));
    }
    return keep;
}

/// None where too little weight is left.
HWY_INLINE Ints enough(Ints keep, Ints u, Ints v) {
    const std::array<Ints, 4> weights =
        bilinear_weights({hn::And(u, all(position_one - 1)), hn::And(v, all(position_one - 1))});
    Ints sum = all(0);
    for (int k = 0; k < 4; ++k)
        sum = sum + hn::IfThenElseZero(hn::TestBit(keep, all(1 << k)), weights[k]);
    return hn::IfThenElseZero(sum > all(int(min_weight * position_one)), keep);
}

/// 1 / x, to 16 bits at least.
HWY_INLINE Floats inverse(Floats x) {
    const Floats near = hn::ApproximateReciprocal(x);
    return near * hn::NegMulAdd(x, near, all(2.0f));
}

/// None where only some samples agree with the point and the smooth surface through all hides it.
HWY_NOINLINE Ints unless_hidden(const WarpJob& job, const ScaledClearance& point, const Distances& clearance_sample,
                                Ints u, Ints v, Ints keep) {
    IntMask open = hn::And(hn::Not(keep == all(0)), hn::Not(keep == all(15)));
    const Floats s = hn::ConvertTo(float_tag, hn::And(u, all(position_one - 1))) * all(1.0f / position_one);
    const Floats t = hn::ConvertTo(float_tag, hn::And(v, all(position_one - 1))) * all(1.0f / position_one);
    Distances over_clearance;
    for (int k = 0; k < 4; ++k)
        over_clearance[k] = inverse(clearance_sample[k]);
    const Floats upper = hn::MulAdd(s, over_clearance[1] - over_clearance[0], over_clearance[0]);
    const Floats lower = hn::MulAdd(s, over_clearance[3] - over_clearance[2], over_clearance[2]);
    // What bends more across the four alone is no smooth surface; what rounding may hide is left to the exact test.
    const Floats twist = hn::Abs((over_clearance[0] - over_clearance[1]) - (over_clearance[2] - over_clearance[3]));
    const FloatMask may_be_smooth =
        twist <= all(1.001f * max_bend * job.agreement.tolerance / job.agreement.box_radius_m);
    const FloatMask may_hide = hn::And(may_be_smooth, point.is_behind(hn::MulAdd(t, lower - upper, upper), min_behind));
    open = hn::And(open, hn::RebindMask(int_tag, may_hide));
    if (hn::AllFalse(int_tag, open))
        return keep;
    alignas(64) std::int32_t us[lanes], vs[lanes], kept[lanes], opened[lanes];
    alignas(64) float points[lanes], ss[lanes], ts[lanes];
    hn::Store(u, int_tag, us);
    hn::Store(v, int_tag, vs);
    hn::Store(s, float_tag, ss);
    hn::Store(t, float_tag, ts);
    hn::Store(keep, int_tag, kept);
    hn::Store(point.over_clearance(), float_tag, points);
    const auto count = int(hn::CompressStore(hn::Iota(int_tag, 0), open, int_tag, opened));
    const ImageView<const float>& depth_m = job.source.depth_m;
    for (int k = 0; k < count; ++k) {
        const int i = opened[k], x = us[i] >> position_bits, y = vs[i] >> position_bits;
        const bool inside = x > 0 && y > 0 && x < job.grid.width - 2 && y < job.grid.height - 2;
        if (inside ? surface_hides(job.agreement, depth_m.pixel(x - 1, y - 1), depth_m.row_stride,
                                   {ss[i], ts[i], points[i]})
                   : equistream::surface_hides(job.agreement, job.grid, depth_m, us[i], vs[i], points[i]))
            kept[i] = 0;
    }
    return hn::Load(int_tag, kept);
}

HWY_INLINE Distances distances_one_by_one(const ImageView<const float>& depth_m, const SamplesAround& around) {
    Distances result;
    const Ints stride = all(int(depth_m.row_stride));
    for (int k = 0; k < 4; ++k)
        result[k] = hn::GatherIndex(float_tag, depth_m.data,
                                    hn::Load(int_tag, around.y[k]) * stride + hn::Load(int_tag, around.x[k]));
    return result;
}

/// The same by pairs that lie side by side, from the first one's offset in bytes.
HWY_INLINE Distances distances_by_pairs(const ImageView<const float>& depth_m, const std::int32_t* offset) {
    const hn::Repartition<std::uint8_t, FloatTag> bytes;
    const auto row = [&](const float* first, Floats& left, Floats& right) HWY_ATTR {
        const auto* base = reinterpret_cast<const std::uint8_t*>(first);
        const Floats low = hn::BitCast(float_tag, load_eights(bytes, base, offset));
        const Floats high = hn::BitCast(float_tag, load_eights(bytes, base, offset + lanes / 2));
        left = hn::ConcatEven(float_tag, high, low);
        right = hn::ConcatOdd(float_tag, high, low);
    };
    Distances result;
    row(depth_m.data, result[0], result[1]);
    row(depth_m.data + depth_m.row_stride, result[2], result[3]);
    return result;
}

/// A tile of points before the source's distances are looked at.
struct SeenTile {
    alignas(64) std::int32_t offset[tile_pixels];  ///< of the first sample's distance, in bytes
    alignas(64) float length[tile_pixels];         ///< as of SeenPoints
    std::uint32_t outside = 0;                     ///< as of locate
};

// Parts of a tile's work are not inlined into one another: that takes far longer to compile, and is no faster.

/// Positions of the points that a tile's pixels see; `keep` is 15 where the source covers them and looks at their
/// front.
HWY_NOINLINE void map_points(const WarpJob& job, const InversePlanarRows& rows, Tile& tile, SeenTile& seen) {
    tile.regular = false;
    seen.outside = 0;
    const LastCell last{job.grid.width - 2, job.grid.height - 2};
    const Ints stride = all(int(job.source.depth_m.row_stride));
    for (int at = 0; at < tile_pixels; at += lanes) {
        const SeenPoints s = seen_points(job, rows, tile, at % tile_width, at / tile_width);
        const Positions p = project(job.grid, s.direction);
        // Neither what is no distance nor what is none to speak of.
        const FloatMask there = s.inverse_planar < all(far_distance_m);
        FloatMask shown = hn::And(there, inside(job.grid, p));
        if (job.only_seen)
            shown = hn::AndNot(shows_back(job.rays, s), shown);
        const Ints u = fixed_point(hn::IfThenElseZero(shown, p.u)), v = fixed_point(hn::IfThenElseZero(shown, p.v));
        const Cells cells = brought_inside(hn::ShiftRight<position_bits>(u), hn::ShiftRight<position_bits>(v), last);
        const bool whole = last.x >= 0 && last.y >= 0 && hn::AllFalse(int_tag, cells.outside);
        seen.outside |= whole ? 0u : 1u << (at / lanes);
        hn::Store(u, int_tag, tile.u + at);
        hn::Store(v, int_tag, tile.v + at);
        hn::Store(hn::ShiftLeft<2>(cells.y * stride + cells.x), int_tag, seen.offset + at);
        hn::Store(s.length, float_tag, seen.length + at);
        hn::Store(hn::IfThenElseZero(hn::RebindMask(int_tag, shown), all(15)), int_tag, tile.keep + at);
    }
}

/// Leaves in `keep` the samples that show the points; true if those are all.
HWY_NOINLINE bool test_samples(const WarpJob& job, const InversePlanarRows& rows, const SeenTile& seen, Tile& tile) {
    ask_ahead(reinterpret_cast<const std::uint8_t*>(job.source.depth_m.data), 4 * job.source.depth_m.row_stride,
              seen.offset);
    bool whole = true;
    for (int at = 0; at < tile_pixels; at += lanes) {
        const int i = at % tile_width, row = at / tile_width;
        const Ints shown = hn::Load(int_tag, tile.keep + at);
        const Ints u = hn::Load(int_tag, tile.u + at), v = hn::Load(int_tag, tile.v + at);
        Distances clearance_sample, behind;
        if ((seen.outside >> (at / lanes) & 1) == 0) {
            clearance_sample = distances_by_pairs(job.source.depth_m, seen.offset + at);
        } else {
            SamplesAround around;
            samples_around(job.grid, hn::ShiftRight<position_bits>(u), hn::ShiftRight<position_bits>(v), around);
            clearance_sample = distances_one_by_one(job.source.depth_m, around);
        }
        const ScaledClearance point(job.agreement, hn::Load(float_tag, seen.length + at),
                                    hn::LoadU(float_tag, rows.at(tile.x + i, row)));
        Ints keep = all(0);
        for (int k = 0; k < 4; ++k) {
            clearance_sample[k] = formulas::clearance_of(clearance_sample[k], job.agreement.box_radius_m);
            behind[k] = point.behind(clearance_sample[k]);
            const IntMask agrees = hn::RebindMask(int_tag, point.same(behind[k], clearance_sample[k]));
            keep = hn::Or(keep, hn::IfThenElseZero(agrees, all(1 << k)));
        }
        keep = hn::And(keep, shown);
        if (!hn::AllTrue(int_tag, keep == shown)) {
            const SeenPoints s = seen_points(job, rows, tile, i, row);
            keep = enough(hn::And(kept_along_slope(job, s, u, v, clearance_sample, behind, keep), shown), u, v);
            if (!hn::AllTrue(int_tag, hn::Or(keep == all(0), keep == all(15))))
                keep = unless_hidden(job, point, clearance_sample, u, v, keep);
        }
        whole = whole && hn::AllTrue(int_tag, keep == all(15));
        hn::Store(keep, int_tag, tile.keep + at);
    }
    return whole;
}

/// The plane that a tile's points lie in, within `deviation` of 1 / planar depth; false where they do not.
HWY_INLINE bool find_plane(const InversePlanarRows& rows, const Tile& tile, float deviation, InversePlane& plane) {
    constexpr int right = tile_width - 1, bottom = tile_height - 1;
    const float a = rows.at(tile.x, 0)[0], b = rows.at(tile.x, 0)[right];
    const float c = rows.at(tile.x, bottom)[0], d = rows.at(tile.x, bottom)[right];
    plane.per_column = (b - a + d - c) / (2 * right);
    plane.per_row = (c - a + d - b) / (2 * bottom);
    plane.first = 0.25f * (a + b + c + d) - 0.5f * (right * plane.per_column + bottom * plane.per_row);
    for (int row = 0; row < tile_height; ++row)
        for (int i = 0; i < tile_width; i += lanes) {
            const Floats expected =
                hn::MulAdd(columns_from(i), all(plane.per_column), all(plane.first + float(row) * plane.per_row));
            const Floats off = hn::Abs(hn::LoadU(float_tag, rows.at(tile.x + i, row)) - expected);
            if (!hn::AllTrue(float_tag, off <= all(deviation)))
                return false;
        }
    return true;
}

/// Whether no pixel of such a tile can count as the back of a surface: shows_back of the plane, which is the same
/// everywhere, less what deviations of either neighbour can take from it.
inline bool shows_front(const EyeRays& rays, const Tile& tile, const InversePlane& plane, float deviation) {
    const glm::vec3 c = rays.eye_own_axes();
    const float by_slope_x = c.x * rays.focal_px() + c.z * (float(tile.x) - rays.centre_x());
    const float by_slope_y = -c.y * rays.focal_px() + c.z * (float(tile.y) - rays.centre_y());
    const float value = 1 - c.z * plane.first + plane.per_column * by_slope_x + plane.per_row * by_slope_y;
    const float reach_px = std::abs(c.z) * tile_width;
    return value > 2 * deviation * (std::abs(by_slope_x) + std::abs(by_slope_y) + 2 * reach_px + std::abs(c.z));
}

/// map_points for tiles of one plane.
HWY_NOINLINE bool map_plane(const WarpJob& job, const InversePlanarRows& rows, Tile& tile, SeenTile& seen) {
    // Most of what may be off goes to the plane: the fit needs little.
    const float error = 0.25f * job.interpolation;
    const float deviation = 3 * error * job.radians_per_sample / job.rays.distance_m();
    if (tile.columns < tile_width)
        return false;
    InversePlane plane;
    PatchFit fit;
    if (!find_plane(rows, tile, deviation, plane) || !shows_front(job.rays, tile, plane, deviation) ||
        !fit.fit(job, tile.x, tile.y, tile_width, plane, error))
        return false;
    const Ints stride = all(int(job.source.depth_m.row_stride));
    for (int row = 0; row < tile_height; ++row)
        for (int i = 0; i < tile_width; i += lanes) {
            const int at = row * tile_width + i;
            const Floats across = fit.across_from(tile.x + i);
            const Ints u = fit.u(row, across), v = fit.v(row, across);
            const Ints cell = hn::ShiftRight<position_bits>(v) * stride + hn::ShiftRight<position_bits>(u);
            hn::Store(u, int_tag, tile.u + at);
            hn::Store(v, int_tag, tile.v + at);
            hn::Store(hn::ShiftLeft<2>(cell), int_tag, seen.offset + at);
            hn::Store(fit.length(row, across), float_tag, seen.length + at);
            hn::Store(all(15), int_tag, tile.keep + at);
        }
    seen.outside = 0;
    return true;
}

void map_surface(const WarpJob& job, const InversePlanarRows& rows, Tile& tile) {
    SeenTile seen;
    const bool plane = map_plane(job, rows, tile, seen);
    if (!plane)
        map_points(job, rows, tile, seen);
    const bool whole = !job.only_seen || test_samples(job, rows, seen, tile);
    tile.regular = plane && whole;
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
