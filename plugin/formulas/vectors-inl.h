// The formulas of *.glsl.h (scalars.h), read in Highway's vectors. Whoever includes this has named Floats, FloatMask
// and all(float) in its own namespace before. Included once for each instruction set.
#if defined(EQUISTREAM_FORMULAS_VECTORS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_FORMULAS_VECTORS_INL_H
#undef EQUISTREAM_FORMULAS_VECTORS_INL_H
#else
#define EQUISTREAM_FORMULAS_VECTORS_INL_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE::formulas {

/// A number of each lane; a single one counts for all.
struct Number {
    HWY_INLINE Number(Floats all_lanes) : lanes(all_lanes) {}
    HWY_INLINE Number(float number) : lanes(all(number)) {}
    HWY_INLINE operator Floats() const { return lanes; }

    Floats lanes;
};

/// Of each lane. What both sides of && and || say is always computed.
using Truth = FloatMask;

HWY_INLINE Number operator+(Number a, Number b) {
    return a.lanes + b.lanes;
}
HWY_INLINE Number operator-(Number a, Number b) {
    return a.lanes - b.lanes;
}
HWY_INLINE Number operator*(Number a, Number b) {
    return a.lanes * b.lanes;
}
HWY_INLINE Number operator/(Number a, Number b) {
    return a.lanes / b.lanes;
}
HWY_INLINE Number operator-(Number a) {
    return hwy::HWY_NAMESPACE::Neg(a.lanes);
}
HWY_INLINE Truth operator<(Number a, Number b) {
    return a.lanes < b.lanes;
}
HWY_INLINE Truth operator>(Number a, Number b) {
    return a.lanes > b.lanes;
}
HWY_INLINE Truth operator<=(Number a, Number b) {
    return a.lanes <= b.lanes;
}
HWY_INLINE Truth operator>=(Number a, Number b) {
    return a.lanes >= b.lanes;
}
HWY_INLINE Truth operator&&(Truth a, Truth b) {
    return hwy::HWY_NAMESPACE::And(a, b);
}
HWY_INLINE Truth operator||(Truth a, Truth b) {
    return hwy::HWY_NAMESPACE::Or(a, b);
}

HWY_INLINE Number abs(Number x) {
    return hwy::HWY_NAMESPACE::Abs(x.lanes);
}
HWY_INLINE Number max(Number a, Number b) {
    return hwy::HWY_NAMESPACE::Max(a.lanes, b.lanes);
}
HWY_INLINE Number min(Number a, Number b) {
    return hwy::HWY_NAMESPACE::Min(a.lanes, b.lanes);
}
HWY_INLINE Number sqrt(Number x) {
    return hwy::HWY_NAMESPACE::Sqrt(x.lanes);
}
HWY_INLINE Number select(Truth condition, Number yes, Number no) {
    return hwy::HWY_NAMESPACE::IfThenElse(condition, yes.lanes, no.lanes);
}
HWY_INLINE Number with_sign_of(Number magnitude, Number sign) {
    return hwy::HWY_NAMESPACE::CopySign(magnitude.lanes, sign.lanes);
}

#define FORMULA HWY_INLINE
#define CONSTANT constexpr
#include "mapping.glsl.h"
#undef FORMULA
#undef CONSTANT

}  // namespace equistream::HWY_NAMESPACE::formulas
HWY_AFTER_NAMESPACE();

#endif
