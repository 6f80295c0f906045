// The formulas of depth_agreement.h in vectors.
#if defined(EQUISTREAM_DEPTH_AGREEMENT_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_DEPTH_AGREEMENT_INL_H
#undef EQUISTREAM_DEPTH_AGREEMENT_INL_H
#else
#define EQUISTREAM_DEPTH_AGREEMENT_INL_H
#endif

#include <equistream/depth_agreement.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

/// r - B, for distances up to infinity; NaN stays.
template <typename Tag, typename Distances = hwy::HWY_NAMESPACE::Vec<Tag>>
HWY_INLINE Distances clearance(Tag d, float box_radius_m, Distances distance_m) {
    namespace hn = hwy::HWY_NAMESPACE;
    const Distances far = hn::Set(d, far_distance_m);
    // Not the smaller of both, which on some targets is the other one of a NaN.
    const Distances r = hn::IfThenElse(hn::Gt(distance_m, far), far, distance_m);
    return hn::Max(hn::Mul(r, hn::Set(d, min_clearance_share)), hn::Sub(r, hn::Set(d, box_radius_m)));
}

/// w = B / (r - B).
template <typename Tag, typename Distances = hwy::HWY_NAMESPACE::Vec<Tag>>
HWY_INLINE Distances w_of(Tag d, float box_radius_m, Distances distance_m) {
    namespace hn = hwy::HWY_NAMESPACE;
    return hn::Div(hn::Set(d, box_radius_m), clearance(d, box_radius_m, distance_m));
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
