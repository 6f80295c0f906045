#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "sphere_edges.cpp"
#include "sphere_edges.h"
#include "surface_planes.h"

#include <hwy/foreach_target.h>

#include "plane_lanes-inl.h"

#include <array>
#include <utility>

HWY_BEFORE_NAMESPACE();
namespace equistream {
namespace HWY_NAMESPACE {

/// The difference in s that makes the largest error in w: dw/ds = B / (1 - B s)^2.
V Allowed(const SphereWarp& warp, V s) {
    const D d;
    const V to_box = hn::NegMulAdd(s, hn::Set(d, warp.box_radius_m), hn::Set(d, 1.0f));
    return hn::Mul(hn::Set(d, warp.error / warp.box_radius_m), hn::Mul(to_box, to_box));
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

Planes PlanesFrom(const PlaneRow& row, int column) {
    const D d;
    return {hn::LoadU(d, row.x.data() + column), hn::LoadU(d, row.y.data() + column),
            hn::LoadU(d, row.z.data() + column), hn::LoadU(d, row.scale.data() + column)};
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
        const std::array<Planes, 4> planes = {PlanesFrom(rows.planes, x), PlanesFrom(rows.planes, x + 1),
                                              PlanesFrom(rows.planes_below, x), PlanesFrom(rows.planes_below, x + 1)};
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

HWY_EXPORT(SpreadPlanes);
HWY_EXPORT(FindEdges);

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
