// How shaders read the formulas of *.glsl.h (scalars.h). Stands before every shader's text.

#define Number float
#define Truth bool
#define FORMULA
#define CONSTANT const

float select(bool condition, float yes, float no) {
    return condition ? yes : no;
}

bool both(bool a, bool b) {
    return a && b;
}

bool either(bool a, bool b) {
    return a || b;
}

// A comparison with NaN may be taken for min() by a compiler.
float min_or_nan(float x, float most) {
    return isnan(x) ? UNKNOWN : min(x, most);
}

float over_sqrt(float x) {
    return inversesqrt(x);
}

float mantissa_of(float x) {
    return intBitsToFloat((floatBitsToInt(x) & 0x007fffff) | 0x3f800000);
}

float exponent_of(float x) {
    return float((floatBitsToInt(x) >> 23) - 127);
}

float with_sign_of(float magnitude, float sign_of) {
    return sign_of < 0.0 ? -magnitude : magnitude;
}
