#pragma once
/// The formulas of *.glsl.h, read as C++ for one number at a time. Each of those files is one text in
/// three readings: here, in vectors (vectors-inl.h), and in shaders (shaders.glsl). A text uses only
/// what all three give it: FORMULA before a function, CONSTANT before a number, Number and Truth,
/// float, int and bool for what is the same for all pixels, and the functions below.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace equistream::formulas {

using Number = float;
using Truth = bool;

using std::abs;
using std::max;
using std::min;
using std::pow;
using std::sqrt;

inline float select(bool condition, float yes, float no) {
    return condition ? yes : no;
}
inline float with_sign_of(float magnitude, float sign) {
    return std::copysign(magnitude, sign);
}
// Without a branch, so that loops over rows of samples become vector code.
inline bool both(bool a, bool b) {
    return bool(int(a) & int(b));
}
inline bool either(bool a, bool b) {
    return bool(int(a) | int(b));
}
/// NaN for NaN, of which min() may make a number.
inline float min_or_nan(float x, float most) {
    return x > most ? most : x;
}
inline float over_sqrt(float x) {
    return 1 / std::sqrt(x);
}
/// x = mantissa_of(x) * 2^exponent_of(x), the first in [1, 2), for x > 0.
inline float mantissa_of(float x) {
    return std::bit_cast<float>((std::bit_cast<std::uint32_t>(x) & 0x007fffffu) | 0x3f800000u);
}
inline float exponent_of(float x) {
    return float(std::int32_t(std::bit_cast<std::uint32_t>(x) >> 23) - 127);
}

#define FORMULA inline
#define CONSTANT inline constexpr
// clang-format off
#include "agreement.glsl.h"
#include "hiding.glsl.h"
#include "mapping.glsl.h"
#include "push_pull.glsl.h"
#include "risks.glsl.h"
#include "srgb.glsl.h"
#include "wrapping.glsl.h"
// clang-format on
#undef FORMULA
#undef CONSTANT

}  // namespace equistream::formulas
