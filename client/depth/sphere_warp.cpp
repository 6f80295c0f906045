#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sphere_warp.cpp"
#include "sphere_warp.h"
#include "surface_planes.h"

#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

/// Longitudes may turn by no more than this; beyond, the series of Place is too short.
constexpr float largest_turn = 0.1f;

/// The look-up may be this far, in pixels, from where the surface that it found says it should have been.
constexpr float largest_miss_px = 0.5f;

/// Of every lane, to be intersected from one place.
struct Planes {
    V x, y, z, scale;  ///< normal; 1 / distance from that place

    Planes(const SphereWarp& warp, VI numbers) {
        const D d;
        V distance;
        const DI di;
        // Most registers see one plane or, to either side of an edge, two: broadcasts are faster than gathers.
        const std::int32_t one = hn::GetLane(numbers), other = hn::GetLane(hn::Reverse(di, numbers));
        const auto is_one = hn::Eq(numbers, hn::Set(di, one));
        if (hn::AllTrue(di, hn::Or(is_one, hn::Eq(numbers, hn::Set(di, other))))) {
            const float* a = warp.planes + 4 * std::ptrdiff_t(one);
            const float* b = warp.planes + 4 * std::ptrdiff_t(other);
            const auto first = hn::RebindMask(d, is_one);
            x = hn::IfThenElse(first, hn::Set(d, a[0]), hn::Set(d, b[0]));
            y = hn::IfThenElse(first, hn::Set(d, a[1]), hn::Set(d, b[1]));
            z = hn::IfThenElse(first, hn::Set(d, a[2]), hn::Set(d, b[2]));
            distance = hn::IfThenElse(first, hn::Set(d, a[3]), hn::Set(d, b[3]));
        } else {
            const VI at = hn::ShiftLeft<2>(numbers);
            x = hn::GatherIndex(d, warp.planes, at);
            y = hn::GatherIndex(d, warp.planes + 1, at);
            z = hn::GatherIndex(d, warp.planes + 2, at);
            distance = hn::GatherIndex(d, warp.planes + 3, at);
        }
        distance = hn::NegMulAdd(x, hn::Set(d, warp.from_m[0]), distance);
        distance = hn::NegMulAdd(y, hn::Set(d, warp.from_m[1]), distance);
        distance = hn::NegMulAdd(z, hn::Set(d, warp.from_m[2]), distance);
        scale = hn::Div(hn::Set(d, 1.0f), distance);
    }
    Planes(const PlaneRow& row, int column) {
        const D d;
        x = hn::LoadU(d, row.x.data() + column);
        y = hn::LoadU(d, row.y.data() + column);
        z = hn::LoadU(d, row.z.data() + column);
        scale = hn::LoadU(d, row.scale.data() + column);
    }
};

/// Of the pixels of a register, in the world.
struct Directions {
    V x, y, z;

    Directions(const SphereWarp& warp, const SphereRow& row, int column) {
        const D d;
        const V c = hn::Set(d, row.cos_latitude);
        const auto part = [&](int axis) {
            return hn::MulAdd(c, hn::LoadU(d, warp.column_world[axis] + column), hn::Set(d, row.world[axis]));
        };
        x = part(0);
        y = part(1);
        z = part(2);
    }
    /// Inverse distances of planes; 0 or less where they are not before the pixel.
    V meet(const Planes& planes) const {
        return hn::Mul(hn::MulAdd(x, planes.x, hn::MulAdd(y, planes.y, hn::Mul(z, planes.z))), planes.scale);
    }
};

/// The difference in s that makes the largest error in w: dw/ds = B / (1 - B s)^2.
V Allowed(const SphereWarp& warp, V s) {
    const D d;
    const V to_box = hn::NegMulAdd(s, hn::Set(d, warp.box_radius_m), hn::Set(d, 1.0f));
    return hn::Mul(hn::Set(d, warp.error / warp.box_radius_m), hn::Mul(to_box, to_box));
}

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

void SpreadPlanes(const SphereWarp& here, int y, PlaneRow& planes) {
    const D d;
    for (int x = 0; x <= here.width; x += int(hn::Lanes(d))) {
        const Planes seen(here, hn::LoadU(DI(), here.seen->row(y) + x));
        hn::StoreU(seen.x, d, planes.x.data() + x);
        hn::StoreU(seen.y, d, planes.y.data() + x);
        hn::StoreU(seen.z, d, planes.z.data() + x);
        hn::StoreU(seen.scale, d, planes.scale.data() + x);
    }
}

/// How two neighbours' planes go together.
struct Side {
    M parted, touching, hollow, ridge;  ///< none of them: they agree
};

Side Compare(const SphereWarp& here, const std::array<Planes, 2>& planes, const std::array<Directions, 2>& towards) {
    const D d;
    const V zero = hn::Zero(d);
    const V sa = towards[0].meet(planes[0]), sb = towards[1].meet(planes[1]);
    // By how much each is before the other where it is seen.
    const V at_a = hn::Sub(sa, towards[0].meet(planes[1])), at_b = hn::Sub(sb, towards[1].meet(planes[0]));
    const V allowed = hn::Mul(hn::Set(d, 0.5f), Allowed(here, hn::Max(sa, sb)));
    const auto differ = hn::Not(hn::And(hn::Le(hn::Abs(at_a), allowed), hn::Le(hn::Abs(at_b), allowed)));
    const auto hollow = hn::And(hn::Ge(at_a, zero), hn::Ge(at_b, zero));
    const auto ridge = hn::And(hn::Le(at_a, zero), hn::Le(at_b, zero));
    const auto near = hn::Le(hn::Min(hn::Abs(at_a), hn::Abs(at_b)), allowed);
    const auto apart = hn::And(differ, hn::Not(hn::Or(hollow, ridge)));
    return {hn::And(apart, hn::Not(near)), hn::And(apart, near), hn::And(differ, hollow), hn::And(differ, ridge)};
}

void FindEdges(const SphereWarp& here, const RowPair& rows, std::uint8_t* cells, std::int32_t* tiles,
               std::vector<int>& edges) {
    const D d;
    const DI di;
    const hn::Rebind<std::uint8_t, D> d8;
    const std::int32_t *upper = here.seen->row(rows.row.y), *lower = here.seen->row(rows.below.y);
    for (int x = 0; x < here.width; x += int(hn::Lanes(d))) {
        std::int32_t& tile = tiles[x / carried_tile_width];
        const std::array<VI, 4> number = {hn::LoadU(di, upper + x), hn::LoadU(di, upper + x + 1),
                                          hn::LoadU(di, lower + x), hn::LoadU(di, lower + x + 1)};
        const auto one =
            hn::And(hn::And(hn::Eq(number[0], number[1]), hn::Eq(number[2], number[3])), hn::Eq(number[0], number[2]));
        if (!hn::AllTrue(di, hn::And(one, hn::Eq(number[0], hn::Set(di, tile)))))
            tile = mixed;
        if (hn::AllTrue(di, one)) {
            hn::StoreU(hn::DemoteTo(d8, hn::Set(di, Cell::agreeing)), d8, cells + x);
            continue;
        }
        const std::array<Planes, 4> planes = {Planes(rows.planes, x), Planes(rows.planes, x + 1),
                                              Planes(rows.planes_below, x), Planes(rows.planes_below, x + 1)};
        const std::array<Directions, 4> towards = {Directions(here, rows.row, x), Directions(here, rows.row, x + 1),
                                                   Directions(here, rows.below, x),
                                                   Directions(here, rows.below, x + 1)};
        M parted = hn::Lt(hn::Zero(d), hn::Zero(d)), touching = parted, hollow = parted, ridge = parted;
        auto known = hn::Gt(number[0], hn::Set(di, SurfacePlanes::none));
        for (const VI n : number)
            known = hn::And(known, hn::Gt(n, hn::Set(di, SurfacePlanes::none)));
        for (const auto& [a, b] : {std::pair{std::size_t(0), std::size_t(1)}, {2, 3}, {0, 2}, {1, 3}}) {
            const Side side = Compare(here, {planes[a], planes[b]}, {towards[a], towards[b]});
            parted = hn::Or(parted, side.parted);
            touching = hn::Or(touching, side.touching);
            hollow = hn::Or(hollow, side.hollow);
            ridge = hn::Or(ridge, side.ridge);
        }
        const auto edge = hn::AndNot(hn::RebindMask(d, one), hn::Or(parted, hn::Not(hn::RebindMask(d, known))));
        const auto unclear = hn::Or(hn::Or(edge, touching), hn::And(hollow, ridge));
        const VI joint = hn::IfThenElse(
            hn::RebindMask(di, hollow), hn::Set(di, Cell::foremost),
            hn::IfThenElse(hn::RebindMask(di, ridge), hn::Set(di, Cell::hindmost), hn::Set(di, Cell::agreeing)));
        const VI kind = hn::IfThenElse(hn::RebindMask(di, unclear), hn::Set(di, Cell::parted),
                                       hn::IfThenElse(one, hn::Set(di, Cell::agreeing), joint));
        hn::StoreU(hn::DemoteTo(d8, kind), d8, cells + x);
        if (hn::AllFalse(d, edge))
            continue;
        std::uint8_t bits[16] = {};
        hn::StoreMaskBits(d, edge, bits);
        for (int lane = 0; lane < int(hn::Lanes(d)) && x + lane < here.width; ++lane)
            if ((bits[lane / 8] >> (lane % 8) & 1) != 0)
                edges.push_back(x + lane);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace equistream
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream {

HWY_EXPORT(WarpColumns);
HWY_EXPORT(FillColumns);
HWY_EXPORT(SpreadPlanes);
HWY_EXPORT(FindEdges);

void warp_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last) {
    HWY_DYNAMIC_DISPATCH(WarpColumns)(warp, row, now, first, last);
}

void fill_columns(const SphereWarp& warp, const SphereRow& row, const NewRow& now, int first, int last,
                  std::int32_t plane) {
    HWY_DYNAMIC_DISPATCH(FillColumns)(warp, row, now, first, last, plane);
}

void spread_planes(const SphereWarp& here, int y, PlaneRow& planes) {
    HWY_DYNAMIC_DISPATCH(SpreadPlanes)(here, y, planes);
}

void find_edges(const SphereWarp& here, const RowPair& rows, std::uint8_t* cells, std::int32_t* tiles,
                std::vector<int>& edges) {
    HWY_DYNAMIC_DISPATCH(FindEdges)(here, rows, cells, tiles, edges);
}

PlaneRow::PlaneRow(int width)
    : x(std::size_t(width + PlaneNumbers::margin)), y(x.size()), z(x.size()), scale(x.size()) {}

}  // namespace equistream
#endif
