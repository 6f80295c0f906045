#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sphere_warp.cpp"
#include "sphere_warp.h"
#include "surface_planes.h"

#include <hwy/foreach_target.h>

#include "plane_lanes-inl.h"

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream {
namespace HWY_NAMESPACE {

/// Longitudes may turn by no more than this; beyond, the series of Place is too short.
constexpr float largest_turn = 0.1f;

/// The look-up may be this far, in pixels, from where the surface that it found says it should have been.
constexpr float largest_miss_px = 0.5f;

/// Where a point of inverse distance s' in the new pixel's direction was in the old picture.
struct Place {
    V u, v;
};

/// What is around a place in the old picture.
struct Around {
    VI nearest;    ///< the plane of the nearest pixel
    VI cell;       ///< where the four pixels around are, the upper left of them
    bool in_line;  ///< cells of neighbouring lanes are neighbours
    VI kind;       ///< of the cell
    V off;         ///< by how much the place was beyond the picture, in pixels
};

struct RowWarp {
    D d;
    const SphereWarp& warp;
    const SphereRow& row;
    V across, up, along;  ///< components of t at this pixel
    V u, v;

    RowWarp(const SphereWarp& sphere_warp, const SphereRow& sphere_row, int column)
        : warp(sphere_warp), row(sphere_row) {
        const V sin_l = hn::LoadU(d, warp.sin_longitude + column), cos_l = hn::LoadU(d, warp.cos_longitude + column);
        const V heading = hn::Sub(hn::Mul(hn::Set(d, warp.x_m), sin_l), hn::Mul(hn::Set(d, warp.z_m), cos_l));
        across = hn::MulAdd(hn::Set(d, warp.x_m), cos_l, hn::Mul(hn::Set(d, warp.z_m), sin_l));
        up = hn::NegMulAdd(heading, hn::Set(d, row.sin_latitude), hn::Set(d, warp.y_m * row.cos_latitude));
        along = hn::MulAdd(heading, hn::Set(d, row.cos_latitude), hn::Set(d, warp.y_m * row.sin_latitude));
        u = hn::ConvertTo(d, hn::Iota(DI(), column));
        v = hn::Set(d, float(row.y));
    }

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
    /// How far in pixels a place moves with s, at most; a quarter more for the series.
    V pixels_per_inverse_m() const {
        return hn::MulAdd(hn::Abs(across), hn::Set(d, 1.25f * warp.columns_per_rad / row.cos_latitude),
                          hn::Mul(hn::Abs(up), hn::Set(d, 1.25f * warp.rows_per_rad)));
    }
    /// Below 1 where the series hold.
    V turned(V s) const {
        const float t_squared = warp.x_m * warp.x_m + warp.y_m * warp.y_m + warp.z_m * warp.z_m;
        const float turn = largest_turn * row.cos_latitude;
        return hn::Mul(hn::Mul(s, s), hn::Set(d, t_squared / (turn * turn)));
    }

    /// Written so that NaN becomes the lowest: what is clamped is an address.
    static V clamped(V x, V lowest, V highest) {
        return hn::Min(hn::IfThenElse(hn::Ge(x, lowest), x, lowest), highest);
    }

    /// Neighbours mostly look up neighbours: then a load does, which is several times faster than a gather.
    static bool are_in_line(VI index) {
        const DI di;
        return hn::AllTrue(di, hn::Eq(index, hn::Add(hn::Set(di, hn::GetLane(index)), hn::Iota(di, 0))));
    }
    static VI load(const std::int32_t* from, VI index, bool in_line) {
        const DI di;
        return in_line ? hn::LoadU(di, from + hn::GetLane(index)) : hn::GatherIndex(di, from, index);
    }
    static VI load(const std::uint8_t* from, VI index, bool in_line) {
        const DI di;
        const hn::Rebind<std::uint8_t, D> d8;
        if (in_line)
            return hn::PromoteTo(di, hn::LoadU(d8, from + hn::GetLane(index)));
        // Four bytes from each, of which the first counts; planes have spare ones behind them.
        const VI words = hn::GatherOffset(di, reinterpret_cast<const std::int32_t*>(from), index);
        return hn::And(words, hn::Set(di, 0xff));
    }

    Around look(V s) const {
        const DI di;
        using Numbers = PlaneNumbers;
        const Place at = place(s);
        const V at_u =
            clamped(at.u, hn::Set(d, float(2 - Numbers::margin)), hn::Set(d, float(warp.width + Numbers::margin - 6)));
        const V at_v = clamped(at.v, hn::Zero(d), hn::Set(d, float(warp.height) - 1.01f));
        const V left = hn::Floor(at_u), top = hn::Floor(at_v), half = hn::Set(d, 0.5f);
        const VI stride = hn::Set(di, warp.seen->stride()), zero = hn::Zero(di);
        Around around;
        around.cell = hn::Add(hn::Mul(hn::ConvertTo(di, top), stride), hn::ConvertTo(di, left));
        around.in_line = are_in_line(around.cell);
        const auto right = hn::RebindMask(di, hn::Gt(hn::Sub(at_u, left), half));
        const auto lower = hn::RebindMask(di, hn::Gt(hn::Sub(at_v, top), half));
        const VI pixel = hn::Add(
            around.cell, hn::Add(hn::IfThenElse(right, hn::Set(di, 1), zero), hn::IfThenElse(lower, stride, zero)));
        around.nearest = load(warp.seen->row(0), pixel, are_in_line(pixel));
        around.kind = load(warp.cells->row(0), around.cell, around.in_line);
        around.off = hn::Add(hn::AbsDiff(at.u, at_u), hn::AbsDiff(at.v, at_v));
        return around;
    }
    VI corner(const Around& around, int i) const {
        return load(warp.seen->row(0) + i / 2 * warp.seen->stride() + i % 2, around.cell, around.in_line);
    }
};

/// What a register of pixels came to.
struct Told {
    V s;
    VI number;
    M sure;
};

/// Where planes that meet inside a cell do: the foremost or the hindmost of its corners'.
void MeetCorners(const RowWarp& at, const Directions& towards, const Around& around, Told& told) {
    const D d;
    const DI di;
    const auto ridge = hn::Eq(around.kind, hn::Set(di, Cell::hindmost));
    const auto joint = hn::Or(ridge, hn::Eq(around.kind, hn::Set(di, Cell::foremost)));
    const V sign = hn::IfThenElse(hn::RebindMask(d, ridge), hn::Set(d, -1.0f), hn::Set(d, 1.0f));
    V best = hn::Set(d, -std::numeric_limits<float>::infinity());
    VI number = told.number;
    for (int i = 0; i < 4; ++i) {
        const VI corner = at.corner(around, i);
        const V s = hn::Mul(sign, towards.meet(Planes(at.warp, corner)));
        const auto better = hn::Gt(s, best);
        best = hn::IfThenElse(better, s, best);
        number = hn::IfThenElse(hn::RebindMask(di, better), corner, number);
    }
    told.s = hn::IfThenElse(hn::RebindMask(d, joint), hn::Mul(sign, best), told.s);
    told.number = hn::IfThenElse(joint, number, told.number);
}

Told Find(const RowWarp& at, const Directions& towards, VI before) {
    const D d;
    const DI di;
    const VI none = hn::Set(di, SurfacePlanes::none), agreeing = hn::Set(di, Cell::agreeing);
    const V farthest = hn::Set(d, largest_miss_px);
    // Most pixels see what they saw: there its plane tells at once where to look.
    const V guess = towards.meet(Planes(at.warp, before));
    const Around first = at.look(guess);
    const auto same =
        hn::And(hn::Eq(first.nearest, before), hn::And(hn::Eq(first.kind, agreeing), hn::Gt(before, none)));
    const auto done = hn::And(hn::RebindMask(d, same), hn::Lt(first.off, farthest));
    if (hn::AllTrue(d, done))
        return {guess, before, done};
    // Others look again from where the nearest plane there says.
    const V again = towards.meet(Planes(at.warp, first.nearest));
    const Around second = at.look(again);
    Told told{again, second.nearest, done};
    if (!hn::AllTrue(di, hn::Eq(second.nearest, first.nearest)))
        told.s = towards.meet(Planes(at.warp, second.nearest));
    if (!hn::AllTrue(di, hn::Lt(second.kind, hn::Set(di, Cell::foremost))))
        MeetCorners(at, towards, second, told);
    const V missed = hn::MulAdd(hn::AbsDiff(told.s, again), at.pixels_per_inverse_m(), second.off);
    const auto known = hn::And(hn::Gt(told.number, none), hn::Ne(second.kind, hn::Set(di, Cell::parted)));
    const auto sure = hn::And(hn::RebindMask(d, known), hn::Lt(missed, farthest));
    return {hn::IfThenElse(done, guess, told.s), hn::IfThenElse(hn::RebindMask(di, done), before, told.number),
            hn::Or(done, sure)};
}

V Distance(V s) {
    const D d;
    return hn::Div(hn::Set(d, 1.0f), hn::Abs(s));  // never -inf for a miss
}

void WarpColumns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last) {
    const D d;
    const DI di;
    const hn::Rebind<std::uint8_t, D> d8;
    const V zero = hn::Zero(d), one = hn::Set(d, 1.0f);
    for (int x = first; x < last; x += int(hn::Lanes(d))) {
        const auto free = hn::RebindMask(d, hn::Eq(hn::PromoteTo(di, hn::LoadU(d8, now.cast + x)), hn::Zero(di)));
        if (hn::AllFalse(d, free))
            continue;
        const RowWarp at(warp, row, x);
        const Told told = Find(at, Directions(warp, row, x), hn::LoadU(di, warp.seen->row(row.y) + x));
        const auto outside_box = hn::Lt(hn::Mul(told.s, hn::Set(d, warp.box_radius_m)), one);
        const auto valid = hn::And(hn::And(hn::Ge(told.s, zero), outside_box), hn::Lt(at.turned(told.s), one));
        const auto sure = hn::And(free, hn::And(told.sure, valid));
        hn::StoreU(Distance(told.s), d, now.distance_m + x);
        hn::StoreU(told.number, di, now.seen + x);
        const VI flags = hn::IfThenZeroElse(hn::RebindMask(di, sure), hn::Set(di, 1));
        hn::StoreU(hn::DemoteTo(d8, flags), d8, now.cast + x);
    }
}

void FillColumns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last,
                 std::int32_t plane) {
    const D d;
    const DI di;
    const VI number = hn::Set(di, plane);
    const Planes planes(warp, number);
    for (int x = first; x < last; x += int(hn::Lanes(d))) {
        hn::StoreU(Distance(Directions(warp, row, x).meet(planes)), d, now.distance_m + x);
        hn::StoreU(number, di, now.seen + x);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace equistream
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(WarpColumns);
HWY_EXPORT(FillColumns);

void warp_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last) {
    HWY_DYNAMIC_DISPATCH(WarpColumns)(warp, row, now, first, last);
}

void fill_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last,
                  std::int32_t plane) {
    HWY_DYNAMIC_DISPATCH(FillColumns)(warp, row, now, first, last, plane);
}

}  // namespace equistream
#endif
