#pragma once
/// The formulas of *.glsl.h, read as C++ for one number at a time. Each of those files is one text in
/// three readings: here, in vectors (vectors-inl.h), and in shaders (shaders.glsl). A text uses only
/// what all three give it: FORMULA before a function, CONSTANT before a number, Number and Truth,
/// float, int and bool for what is the same for all pixels, and the functions below.
#include <algorithm>
#include <cmath>

namespace equistream::formulas {

using Number = float;
using Truth = bool;

using std::abs;
using std::max;
using std::min;
using std::sqrt;

inline float select(bool condition, float yes, float no) {
    return condition ? yes : no;
}
inline float with_sign_of(float magnitude, float sign) {
    return std::copysign(magnitude, sign);
}

#define FORMULA inline
#define CONSTANT inline constexpr
#include "mapping.glsl.h"
#include "wrapping.glsl.h"
#undef FORMULA
#undef CONSTANT

}  // namespace equistream::formulas
