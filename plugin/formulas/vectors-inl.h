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
    Number() = default;
    HWY_INLINE Number(Floats all_lanes) : lanes(all_lanes) {}
    HWY_INLINE Number(float number) : lanes(all(number)) {}
    HWY_INLINE operator Floats() const { return lanes; }

    Floats lanes;
};

/// Of each lane.
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
HWY_INLINE Truth both(Truth a, Truth b) {
    return hwy::HWY_NAMESPACE::And(a, b);
}
HWY_INLINE Truth either(Truth a, Truth b) {
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
HWY_INLINE Number min_or_nan(Number x, Number most) {
    return select(x > most, most, x);
}
/// 1 / sqrt(x) within 3e-7 of itself, for what is neither 0 nor infinite: one step of Newton's from the processor's
/// guess.
HWY_INLINE Number over_sqrt(Number x) {
    const Number guess = hwy::HWY_NAMESPACE::ApproximateReciprocalSqrt(x.lanes);
    return guess * (1.5f - 0.5f * x * (guess * guess));
}

using NumberTag = hwy::HWY_NAMESPACE::DFromV<Floats>;
using BitsTag = hwy::HWY_NAMESPACE::RebindToSigned<NumberTag>;

HWY_INLINE Number mantissa_of(Number x) {
    namespace hn = hwy::HWY_NAMESPACE;
    const BitsTag bits;
    const auto fraction = hn::And(hn::BitCast(bits, x.lanes), hn::Set(bits, 0x007fffff));
    return hn::BitCast(NumberTag(), hn::Or(fraction, hn::Set(bits, 0x3f800000)));
}
HWY_INLINE Number exponent_of(Number x) {
    namespace hn = hwy::HWY_NAMESPACE;
    const BitsTag bits;
    return hn::ConvertTo(NumberTag(), hn::Sub(hn::ShiftRight<23>(hn::BitCast(bits, x.lanes)), hn::Set(bits, 127)));
}

#define FORMULA HWY_INLINE
#define CONSTANT constexpr
// clang-format off
#include "agreement.glsl.h"
#include "mapping.glsl.h"
#include "push_pull.glsl.h"
#include "risks.glsl.h"
// clang-format on
#undef FORMULA
#undef CONSTANT

}  // namespace equistream::HWY_NAMESPACE::formulas
HWY_AFTER_NAMESPACE();

#endif
