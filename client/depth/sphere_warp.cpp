#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sphere_warp.cpp"
#include "sphere_warp.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;

/// A look-up this part of the error beside its place is not worth another.
constexpr float look_again_above = 1.0f / 64;

/// Longitudes may turn by no more than this; beyond, the series of Place is too short.
constexpr float largest_turn = 0.1f;

/// A parabola is this part of its second difference off the line through its neighbours, in the middle.
constexpr float part_of_bend = 0.125f;

/// Where a point of inverse distance s' in the new pixel's direction was in the old picture.
struct Place {
    V u, v;
};

/// Pixels in memory that a register's lanes look up. Neighbours mostly look up neighbours: then a load does, which is
/// several times faster than a gather.
struct LookUp {
    D d;
    VI index;
    bool in_line;

    explicit LookUp(VI at) : index(at) {
        const DI di;
        in_line = hn::AllTrue(di, hn::Eq(at, hn::Add(hn::Set(di, hn::GetLane(at)), hn::Iota(di, 0))));
    }
    V from(const float* plane) const {
        return in_line ? hn::LoadU(d, plane + hn::GetLane(index)) : hn::GatherIndex(d, plane, index);
    }
};

/// What a look-up came to.
struct Found {
    V inverse_m;   ///< now
    V look_error;  ///< in w, by having looked a little beside the place
    V cost;        ///< in w, of the cell looked up
    V small;       ///< below 1 where the series here hold
};

struct RowWarp {
    D d;
    const SphereWarp& warp;
    const SphereRow& row;
    V across, up, along, across_squared;  ///< components of t at this pixel; |t|^2 - along^2
    V u, v;

    /// 1 / (1 - x) within x^4, which for turns up to largest_turn is a thousandth of a pixel.
    V about_inverse(V x) const {
        const V one = hn::Set(d, 1.0f);
        return hn::MulAdd(hn::MulAdd(hn::Add(x, one), x, one), x, one);
    }
    Place place(V s) const {
        const V inverse = hn::Mul(s, about_inverse(hn::Neg(hn::Mul(s, along))));
        const V azimuth = hn::Mul(across, inverse), elevation = hn::Mul(up, inverse);
        const V tangent = hn::Set(d, row.sin_latitude / row.cos_latitude);
        V longitude =
            hn::Mul(hn::Mul(azimuth, hn::Set(d, 1 / row.cos_latitude)), about_inverse(hn::Mul(elevation, tangent)));
        longitude = hn::NegMulAdd(hn::Mul(longitude, hn::Mul(longitude, longitude)), hn::Set(d, 1.0f / 3), longitude);
        const V half_square = hn::Mul(hn::Mul(azimuth, azimuth), hn::Set(d, 0.5f));
        const V latitude = hn::NegMulAdd(half_square, tangent, elevation);
        return {hn::MulAdd(longitude, hn::Set(d, warp.columns_per_rad), u),
                hn::NegMulAdd(latitude, hn::Set(d, warp.rows_per_rad), v)};
    }
    /// 1 - root + s t.d', root being that of carried by its series.
    V shortening(V s) const {
        const V a = hn::Mul(hn::Mul(s, s), across_squared);
        return hn::MulAdd(hn::MulAdd(a, hn::Set(d, 0.125f), hn::Set(d, 0.5f)), a, hn::Mul(s, along));
    }
    V carried(V s) const { return hn::Div(s, hn::Sub(hn::Set(d, 1.0f), shortening(s))); }
    /// Good enough to look the next one up.
    V about_carried(V s) const { return hn::Mul(s, about_inverse(shortening(s))); }

    /// Written so that NaN becomes the lowest: what is clamped is an address.
    static V clamped(V x, V lowest, V highest) {
        return hn::Min(hn::IfThenElse(hn::Ge(x, lowest), x, lowest), highest);
    }

    Found find(V guess) const {
        const DI di;
        const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
        const Place at = place(guess);
        const V at_u = clamped(at.u, hn::Set(d, float(2 - PaddedPlane::margin)),
                               hn::Set(d, float(warp.width + PaddedPlane::margin - 3)));
        const V at_v = clamped(at.v, zero, hn::Set(d, float(warp.height) - 1.01f));
        const V left = hn::Floor(at_u), top = hn::Floor(at_v);
        const V fu = hn::Sub(at_u, left), fv = hn::Sub(at_v, top);
        const VI stride = hn::Set(di, warp.inverse_m->stride());
        const LookUp cell(hn::Add(hn::Mul(hn::ConvertTo(di, top), stride), hn::ConvertTo(di, left)));
        const float* first = warp.inverse_m->row(0);
        const float* second = first + warp.inverse_m->stride();
        const V s00 = cell.from(first), s10 = cell.from(first + 1);
        const V s01 = cell.from(second), s11 = cell.from(second + 1);
        const V upper = hn::MulAdd(fu, hn::Sub(s10, s00), s00), lower = hn::MulAdd(fu, hn::Sub(s11, s01), s01);
        const V s = carried(hn::MulAdd(fv, hn::Sub(lower, upper), upper));
        const V slope = hn::Max(hn::Max(hn::AbsDiff(s10, s00), hn::AbsDiff(s01, s00)),
                                hn::Max(hn::AbsDiff(s11, s10), hn::AbsDiff(s11, s01)));
        // How far the look-up was from where s says it should have been, in pixels; a quarter more for the series.
        const V pixels = hn::MulAdd(hn::Abs(across), hn::Set(d, 1.25f * warp.columns_per_rad / row.cos_latitude),
                                    hn::Mul(hn::Abs(up), hn::Set(d, 1.25f * warp.rows_per_rad)));
        const V clamping = hn::Add(hn::AbsDiff(at.u, at_u), hn::AbsDiff(at.v, at_v));
        const V off = hn::MulAdd(hn::AbsDiff(s, guess), pixels, clamping);
        const V to_box = hn::NegMulAdd(s, hn::Set(d, warp.box_radius_m), one);
        const V w_of_s = hn::Div(hn::Set(d, warp.box_radius_m), hn::Mul(to_box, to_box));
        const float t_squared = warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m;
        const float turn = largest_turn * row.cos_latitude;
        const V turned = hn::Mul(hn::Mul(s, s), hn::Set(d, t_squared / (turn * turn)));
        const V outside = hn::IfThenElse(hn::Gt(to_box, zero), turned, hn::Set(d, 2.0f));
        return {s, hn::Mul(hn::Mul(w_of_s, slope), off), cell.from(warp.cost->row(0)), hn::Max(off, outside)};
    }
};

void WarpRow(const SphereWarp& warp, const SphereRow& row) {
    const D d;
    const DI di;
    const hn::Rebind<std::uint8_t, D> d8;
    const int lanes = int(hn::Lanes(d));
    const float t_squared = warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f), infinity = hn::Set(d, std::numeric_limits<float>::infinity());
    const V error = hn::Set(d, warp.error), enough = hn::Set(d, warp.error * look_again_above);
    for (int x = 0; x < warp.width; x += lanes) {
        const auto free = hn::RebindMask(d, hn::Eq(hn::PromoteTo(di, hn::LoadU(d8, row.cast + x)), hn::Zero(di)));
        if (hn::AllFalse(d, free))
            continue;
        const V sin_l = hn::LoadU(d, warp.sin_longitude + x), cos_l = hn::LoadU(d, warp.cos_longitude + x);
        const V heading = hn::Sub(hn::Mul(hn::Set(d, warp.x_m), sin_l), hn::Mul(hn::Set(d, warp.z_m), cos_l));
        const V along = hn::MulAdd(heading, hn::Set(d, row.cos_latitude), hn::Set(d, warp.y_m * row.sin_latitude));
        const RowWarp at{d,
                         warp,
                         row,
                         hn::MulAdd(hn::Set(d, warp.x_m), cos_l, hn::Mul(hn::Set(d, warp.z_m), sin_l)),
                         hn::NegMulAdd(heading, hn::Set(d, row.sin_latitude), hn::Set(d, warp.y_m * row.cos_latitude)),
                         along,
                         hn::Max(zero, hn::NegMulAdd(along, along, hn::Set(d, t_squared))),
                         hn::ConvertTo(d, hn::Iota(di, x)),
                         hn::Set(d, float(row.y))};
        // Most pixels find their place at once: depth there is much as it is here. Others look again from there.
        Found found = at.find(at.about_carried(hn::LoadU(d, warp.inverse_m->row(row.y) + x)));
        if (!hn::AllTrue(d, hn::Or(hn::Not(free), hn::Le(found.look_error, enough))))
            found = at.find(found.inverse_m);
        const V total = hn::Add(found.cost, found.look_error);
        const auto told = hn::And(free, hn::And(hn::Le(total, error), hn::Lt(found.small, one)));
        const V s = found.inverse_m;
        hn::StoreU(hn::IfThenElse(hn::Gt(s, zero), hn::Div(one, s), infinity), d, row.distance_m + x);
        hn::StoreU(s, d, row.inverse_m + x);
        hn::StoreU(total, d, row.error + x);
        const VI flags = hn::IfThenZeroElse(hn::RebindMask(di, told), hn::Set(di, 1));
        hn::StoreU(hn::DemoteTo(d8, flags), d8, row.cast + x);
    }
}

/// The smaller second difference of two neighbours in line: along a smooth stretch both are small, beside an edge one
/// is, across it none.
V Bend(D d, V before, V here, V next, V after) {
    const V two = hn::Set(d, 2.0f);
    return hn::Min(hn::Abs(hn::NegMulAdd(two, here, hn::Add(before, next))),
                   hn::Abs(hn::NegMulAdd(two, next, hn::Add(here, after))));
}

void AddInterpolationCost(const PaddedPlane& inverse_m, int y, const SphereWarp& bounds, float* cost,
                          std::vector<EdgeCell>& edges) {
    const D d;
    const int lanes = int(hn::Lanes(d));
    const auto row = [&](int i) { return inverse_m.row(std::clamp(i, 0, bounds.height - 1)); };
    const float *above = row(y - 1), *here = row(y), *below = row(y + 1), *under = row(y + 2);
    const V one = hn::Set(d, 1.0f), error = hn::Set(d, bounds.error);
    for (int x = 0; x < bounds.width; x += lanes) {
        const auto load = [&](const float* from, int offset) { return hn::LoadU(d, from + x + offset); };
        const V s = load(here, 0), s10 = load(here, 1), s01 = load(below, 0), s11 = load(below, 1);
        const V across =
            hn::Max(Bend(d, load(here, -1), s, s10, load(here, 2)), Bend(d, load(below, -1), s01, s11, load(below, 2)));
        const V down =
            hn::Max(Bend(d, load(above, 0), s, s01, load(under, 0)), Bend(d, load(above, 1), s10, s11, load(under, 1)));
        const V nearest = hn::Max(hn::Max(s, s10), hn::Max(s01, s11));
        const V to_box = hn::NegMulAdd(nearest, hn::Set(d, bounds.box_radius_m), one);
        const V w_of_s = hn::Div(hn::Set(d, bounds.box_radius_m), hn::Mul(to_box, to_box));
        const V own = hn::Mul(hn::Mul(w_of_s, hn::Set(d, part_of_bend)), hn::Add(across, down));
        const auto edge = hn::Not(hn::And(hn::Le(own, error), hn::Gt(to_box, hn::Zero(d))));
        hn::StoreU(hn::IfThenElse(edge, hn::Set(d, std::numeric_limits<float>::infinity()),
                                  hn::Add(own, hn::LoadU(d, cost + x))),
                   d, cost + x);
        if (hn::AllFalse(d, edge))
            continue;
        std::uint8_t bits[16] = {};
        hn::StoreMaskBits(d, edge, bits);
        for (int lane = 0; lane < lanes && x + lane < bounds.width; ++lane) {
            if ((bits[lane / 8] >> (lane % 8) & 1) == 0)
                continue;
            const int i = x + lane;
            const auto [low, high] = std::minmax({here[i], here[i + 1], below[i], below[i + 1]});
            edges.push_back({i, low, high});
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace equistream
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(WarpRow);
HWY_EXPORT(AddInterpolationCost);

void warp_row(const SphereWarp& warp, const SphereRow& row) {
    HWY_DYNAMIC_DISPATCH(WarpRow)(warp, row);
}

void add_interpolation_cost(const PaddedPlane& inverse_m, int y, const SphereWarp& bounds, float* cost,
                            std::vector<EdgeCell>& edges) {
    HWY_DYNAMIC_DISPATCH(AddInterpolationCost)(inverse_m, y, bounds, cost, edges);
}

void PaddedPlane::pad(int y, bool closes, float beyond) {
    float* values = row(y);
    for (int i = 0; i < margin; ++i) {
        values[width_ + i] = closes ? values[i % width_] : beyond;
        values[-1 - i] = closes ? values[width_ - 1 - i % width_] : beyond;
    }
}

}  // namespace equistream
#endif
