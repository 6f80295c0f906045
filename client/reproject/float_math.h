#pragma once
/// Single-precision pieces of the fast path, each within the accuracy its comment states (tested).
#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {

struct Vec3f {
    float x = 0, y = 0, z = 0;
};

inline Vec3f operator+(Vec3f a, Vec3f b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Vec3f operator*(Vec3f a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
inline float dot(Vec3f a, Vec3f b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// By how much rounding may push a position past a picture's edge, in samples.
inline constexpr float edge_rounding_px = 0.02f;

/// Of an odd minimax polynomial for the arc tangent on [0, 1]; the highest power, 15, first.
inline constexpr std::array<float, 8> atan_coefficients = {-0.004055637f, 0.021866976f, -0.055918365f, 0.096426596f,
                                                           -0.139088192f, 0.199466056f, -0.333298645f, 0.999999337f};

/// atan2 within 4e-7 rad (1/480 of a pixel of a 32,768-wide sphere). NaN for NaN and infinity; 0 at
/// (0, 0).
inline float fast_atan2(float y, float x) {
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float larger = std::max(ax, ay);
    const float a = larger > 0 ? std::min(ax, ay) / larger : larger;
    const float s = a * a;
    float p = 0;
    for (const float coefficient : atan_coefficients)
        p = p * s + coefficient;
    float angle = p * a;
    if (ay > ax)
        angle = 1.57079632679f - angle;
    if (x < 0)
        angle = 3.14159265359f - angle;
    return std::copysign(angle, y) + 0 * (x + y);
}

}  // namespace equistream
