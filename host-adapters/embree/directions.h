#pragma once
/// Small geometry that shading needs: frames, sampled directions, ray origins off a surface, packed unit vectors.
#include <equistream/rec709.h>

#include <glm/glm.hpp>

#include <bit>
#include <cmath>
#include <cstdint>

namespace equistream::embree_host {

inline constexpr float pi_f = 3.14159265358979f;

inline float largest(const glm::vec3& c) {
    return c.x > c.y ? (c.x > c.z ? c.x : c.z) : (c.y > c.z ? c.y : c.z);
}
/// 0, 1 or 2.
inline int longest_axis(const glm::vec3& e) {
    return e.x >= e.y ? (e.x >= e.z ? 0 : 2) : (e.y >= e.z ? 1 : 2);
}
inline bool is_black(const glm::vec3& c) {
    return c.x == 0 && c.y == 0 && c.z == 0;
}

inline glm::vec3 to_vec3(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}
inline void store(const glm::vec3& v, float (&to)[3]) {
    for (int i = 0; i < 3; ++i)
        to[i] = v[i];
}

/// An orthonormal frame around a unit normal, without branches on its direction (Duff et al., JCGT 2017).
struct ShadingFrame {
    glm::vec3 tangent, bitangent, normal;

    explicit ShadingFrame(const glm::vec3& n) : normal(n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1 / (sign + n.z);
        const float b = n.x * n.y * a;
        tangent = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x};
        bitangent = {b, sign + n.y * n.y * a, -n.y};
    }
    glm::vec3 to_local(const glm::vec3& w) const {
        return {glm::dot(w, tangent), glm::dot(w, bitangent), glm::dot(w, normal)};
    }
    glm::vec3 to_world(const glm::vec3& v) const { return v.x * tangent + v.y * bitangent + v.z * normal; }
};

/// Around +Z with density cos / pi.
inline glm::vec3 sample_cosine_hemisphere(const glm::vec2& u) {
    const float r = std::sqrt(u.x);
    const float phi = 2 * pi_f * u.y;
    return {r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - u.x)};
}

/// Around +Z, uniform in the cone whose 1 - cos(angle) is given; exact for cones as narrow as the sun.
inline glm::vec3 sample_cone(const glm::vec2& u, float one_minus_cos) {
    const float below = u.x * one_minus_cos;
    const float sine = std::sqrt(below * (2 - below));
    const float phi = 2 * pi_f * u.y;
    return {sine * std::cos(phi), sine * std::sin(phi), 1 - below};
}

/// Barycentrics (u, v) uniform over a triangle (Heitz's low-distortion map).
inline glm::vec2 sample_triangle(const glm::vec2& u) {
    glm::vec2 b = 0.5f * u;
    if (u.x < u.y)
        b = {0.5f * u.x, u.y - 0.5f * u.x};
    else
        b = {u.x - 0.5f * u.y, 0.5f * u.y};
    return b;
}

/// `p` moved off the surface to the side of `n` by a distance that follows p's own rounding error (Waechter and
/// Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems 2019). A point that was found
/// along a ray, `reach` from its origin, has the error of that distance besides.
inline glm::vec3 offset_origin(const glm::vec3& p, const glm::vec3& n, float reach) {
    constexpr float near_zero = 1.0f / 32, float_scale = 1.0f / 65536, int_scale = 256, reach_scale = 0x1p-21f;
    glm::vec3 moved;
    for (int axis = 0; axis < 3; ++axis) {
        const auto steps = static_cast<std::int32_t>(int_scale * n[axis]);
        const auto bits = std::bit_cast<std::int32_t>(p[axis]);
        const float by_ulps = std::bit_cast<float>(bits + (p[axis] < 0 ? -steps : steps));
        const float by_size = std::abs(p[axis]) < near_zero ? p[axis] + float_scale * n[axis] : by_ulps;
        const float by_reach = p[axis] + reach_scale * reach * n[axis];
        moved[axis] = n[axis] > 0 ? std::max(by_size, by_reach) : std::min(by_size, by_reach);
    }
    return moved;
}

/// A unit vector in 48 bits; its direction is off by less than 5e-5 rad.
struct PackedDirection {
    std::int16_t x = 0, y = 0, z = 32767;
};

/// +Z for a vector without a direction: a triangle without an area has no normal worth keeping.
inline PackedDirection pack_direction(const glm::vec3& direction) {
    const float length = glm::length(direction);
    if (!(length > 0) || !std::isfinite(length))
        return {};
    const auto packed = [&](float v) { return static_cast<std::int16_t>(std::lround(v / length * 32767)); };
    return {packed(direction.x), packed(direction.y), packed(direction.z)};
}

/// The direction, 32,767 long (within a thousandth of a percent): sums of several weigh them alike.
inline glm::vec3 unpack_direction(const PackedDirection& packed) {
    return {static_cast<float>(packed.x), static_cast<float>(packed.y), static_cast<float>(packed.z)};
}

}  // namespace equistream::embree_host
