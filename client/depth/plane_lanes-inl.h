// Planes and directions of a register of pixels: what warping a sphere and finding its edges have in common. Included
// once for each instruction set.
#if defined(EQUISTREAM_PLANE_LANES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_PLANE_LANES_INL_H
#undef EQUISTREAM_PLANE_LANES_INL_H
#else
#define EQUISTREAM_PLANE_LANES_INL_H
#endif

#include "sphere_warp.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using DI = hn::RebindToSigned<D>;
using V = hn::Vec<D>;
using VI = hn::Vec<DI>;
using M = hn::Mask<D>;

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
    Planes(V normal_x, V normal_y, V normal_z, V over_distance)
        : x(normal_x), y(normal_y), z(normal_z), scale(over_distance) {}
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

}  // namespace HWY_NAMESPACE
}  // namespace equistream
HWY_AFTER_NAMESPACE();

#endif
