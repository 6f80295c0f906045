#pragma once
/// Visible normals, and virtual images in mirrors and glass. Hosts shade with visible_normal() and export it.
/// Interpolated or mapped normals may point away from the viewer at a silhouette, where the surface itself does not.
/// Templates on the scalar, as in conventions.h; C++17-clean.
#include <equistream/conventions.h>

#include <limits>

namespace equistream {

/// Smallest cosine between an exported normal and the direction to the viewer.
inline constexpr double min_viewer_cosine = 0.02;

template <typename T>
T dot(const Vector3<T>& a, const Vector3<T>& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// `a` + `factor` `b`
template <typename T>
Vector3<T> sum(const Vector3<T>& a, T factor, const Vector3<T>& b) {
    return {a.x + factor * b.x, a.y + factor * b.y, a.z + factor * b.z};
}

/// The unit shading normal, flipped to the side of `geometric`, and bent towards the viewer until its cosine is
/// min_viewer_cosine or more. `geometric` itself if `shading` has no length. `geometric` and `viewer`, the direction to
/// the viewer, are unit vectors on the same side of the surface.
template <typename T>
Vector3<T> visible_normal(const Vector3<T>& shading, const Vector3<T>& geometric, const Vector3<T>& viewer) {
    using std::sqrt;
    const T length2 = dot(shading, shading);
    const auto has_length = length2 > T(1e-12);
    const T scale = T(1) / sqrt(select(has_length, length2, T(1)));
    const T side = select(dot(shading, geometric) < T(0), T(-scale), scale);
    Vector3<T> n{select(has_length, T(side * shading.x), geometric.x),
                 select(has_length, T(side * shading.y), geometric.y),
                 select(has_length, T(side * shading.z), geometric.z)};
    const T lacking = T(min_viewer_cosine) - dot(n, viewer);
    n = sum(n, select(lacking > T(0), lacking, T(0)), viewer);
    const T normalise = select(lacking > T(0), T(T(1) / sqrt(dot(n, n))), T(1));
    return {normalise * n.x, normalise * n.y, normalise * n.z};
}

// Apparent position of objects that are seen in mirrors and through glass.
//
// A pencil is a ray from the eye with the derivatives of its position and direction by four numbers: the eye's shift
// across the ray (two directions) and the ray's turn at the eye (the same two). It is propagated along the ray, surface
// by surface (H. Igehy, "Tracing Ray Differentials", SIGGRAPH 1999). It ends at a point X, where an eye shifted by y
// and a ray turned by t give the offset A y + B t across the ray. The shifted eye sees X where A y + B t = 0, so its
// direction turns by t = -K y with K = B^-1 A. For an image at distance v the turn is -y / v. So 1 / v is K: a number
// for plane mirrors, where v is the path's length, and a matrix with two principal directions for curved ones. The
// number with the least mean square error over y is half the trace of K. If the object moves by x across its ray, it is
// seen turned by B^-1 x.
//
// Pure functions of values.

/// Most sharp surfaces that are followed along a ray, the first one included.
inline constexpr unsigned max_sharp_surfaces = 8;

/// A surface counts as specular if more than this share of the light that it sends on leaves as a sharp reflection or
/// refraction. Otherwise too much of the visible light is the surface's own, which does not move like the image.
inline constexpr float min_sharp_share = 0.75f;
/// Samples of the AOV `specular`, a mask of 0 and 1, above this value are such surfaces.
inline constexpr float min_specular = 0.5f;

/// Lengths in metres. The derivatives are by the four numbers above, in the order of `count`.
template <typename T>
struct Pencil {
    static constexpr int count = 4;  ///< the eye shifted along across[0], [1]; the ray turned towards across[0], [1]

    Vector3<T> across[2];        ///< unit, across the ray at the eye
    Vector3<T> direction;        ///< unit, of the ray behind the last surface
    Vector3<T> position[count];  ///< derivatives of the position reached; components along the ray do not matter
    Vector3<T> turn[count];      ///< derivatives of the direction

    /// A pencil at the eye; `direction` is unit.
    static Pencil from_eye(const Vector3<T>& direction);

    /// Propagates along the ray.
    void travel(T distance);
    /// Projects the derivatives of the position along the ray onto a surface, whose geometric normal is `normal`.
    void onto_surface(const Vector3<T>& normal);
    /// Reflection: `normal` is the unit shading normal, `bend` its derivatives by the same four numbers.
    void reflect(const Vector3<T>& normal, const Vector3<T> (&bend)[count]);
    /// Refraction into another medium: `normal` on the incident side, `eta` the index of refraction of the incident
    /// medium over that of the other. Not for total reflection.
    void refract(const Vector3<T>& normal, const Vector3<T> (&bend)[count], T eta);

    /// v: apparent distance, from the eye along its ray, of the point reached; with `without_end`, of an object
    /// infinitely far in the ray's direction. +inf for an image at infinity, beyond it or behind the eye.
    template <typename Mask>
    T image_distance(const Mask& without_end) const;
    /// Movement of the image at `distance` from the eye when the point reached moves by `movement`; world space.
    Vector3<T> image_movement(const Vector3<T>& eye_direction, T distance, const Vector3<T>& movement) const;

private:
    /// The 2x2 matrices A and B.
    struct Offsets {
        T a11, a12, a21, a22, b11, b12, b21, b22;
    };
    Offsets offsets(const Vector3<T> (&of)[count]) const;
};

template <typename T>
Vector3<T> scaled(const Vector3<T>& v, T factor) {
    return {v.x * factor, v.y * factor, v.z * factor};
}

template <typename T>
Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// A unit vector perpendicular to a unit vector.
template <typename T>
Vector3<T> any_across(const Vector3<T>& d) {
    using std::sqrt;
    // Towards whichever of two axes is farther from d.
    const auto steep = d.y * d.y > T(0.5);
    const Vector3<T> axis{select(steep, T(1), T(0)), select(steep, T(0), T(1)), T(0)};
    const Vector3<T> v = cross(d, axis);
    return scaled(v, T(T(1) / sqrt(dot(v, v))));
}

template <typename T>
Pencil<T> Pencil<T>::from_eye(const Vector3<T>& direction) {
    Pencil p{};
    p.direction = direction;
    p.across[0] = any_across(direction);
    p.across[1] = cross(p.across[0], direction);
    const Vector3<T> none{T(0), T(0), T(0)};
    for (int i = 0; i < 2; ++i) {
        p.position[i] = p.turn[2 + i] = p.across[i];
        p.position[2 + i] = p.turn[i] = none;
    }
    return p;
}

template <typename T>
void Pencil<T>::travel(T distance) {
    for (int i = 0; i < count; ++i)
        position[i] = sum(position[i], distance, turn[i]);
}

template <typename T>
void Pencil<T>::onto_surface(const Vector3<T>& normal) {
    const T cosine = dot(direction, normal);
    const auto grazing = cosine * cosine < T(1e-8);
    const T inverse = select(grazing, T(0), T(T(1) / select(grazing, T(1), cosine)));
    for (int i = 0; i < count; ++i)
        position[i] = sum(position[i], T(-dot(position[i], normal) * inverse), direction);
}

template <typename T>
void Pencil<T>::reflect(const Vector3<T>& normal, const Vector3<T> (&bend)[count]) {
    const T cosine = dot(direction, normal);
    for (int i = 0; i < count; ++i) {
        const T change = dot(turn[i], normal) + dot(direction, bend[i]);
        turn[i] = sum(sum(turn[i], T(T(-2) * cosine), bend[i]), T(T(-2) * change), normal);
    }
    direction = sum(direction, T(T(-2) * cosine), normal);
}

template <typename T>
void Pencil<T>::refract(const Vector3<T>& normal, const Vector3<T> (&bend)[count], T eta) {
    using std::sqrt;
    const T cosine = dot(direction, normal);
    const T cosine_there = -sqrt(T(1) - eta * eta * (T(1) - cosine * cosine));
    const T mu = eta * cosine - cosine_there;
    const T mu_change = eta - eta * eta * cosine / cosine_there;
    for (int i = 0; i < count; ++i) {
        const T change = dot(turn[i], normal) + dot(direction, bend[i]);
        turn[i] = sum(sum(scaled(turn[i], eta), T(-mu), bend[i]), T(-mu_change * change), normal);
    }
    direction = sum(scaled(direction, eta), T(-mu), normal);
}

template <typename T>
typename Pencil<T>::Offsets Pencil<T>::offsets(const Vector3<T> (&of)[count]) const {
    const Vector3<T> right = any_across(direction), up = cross(right, direction);
    return {dot(of[0], right), dot(of[1], right), dot(of[0], up), dot(of[1], up),
            dot(of[2], right), dot(of[3], right), dot(of[2], up), dot(of[3], up)};
}

template <typename T>
template <typename Mask>
T Pencil<T>::image_distance(const Mask& without_end) const {
    Vector3<T> reached[count];
    for (int i = 0; i < count; ++i)
        reached[i] = {select(without_end, turn[i].x, position[i].x), select(without_end, turn[i].y, position[i].y),
                      select(without_end, turn[i].z, position[i].z)};
    const Offsets o = offsets(reached);
    const T determinant = o.b11 * o.b22 - o.b12 * o.b21;
    const T trace = o.b22 * o.a11 - o.b12 * o.a21 - o.b21 * o.a12 + o.b11 * o.a22;
    // 2 / trace(B^-1 A), without dividing by a determinant of 0.
    const auto ahead = trace * determinant > T(0);
    return select(ahead, T(T(2) * determinant / select(ahead, trace, T(1))), T(std::numeric_limits<float>::infinity()));
}

template <typename T>
Vector3<T> Pencil<T>::image_movement(const Vector3<T>& eye_direction, T distance, const Vector3<T>& movement) const {
    const Vector3<T> right = any_across(direction), up = cross(right, direction);
    const Offsets o = offsets(position);
    const T x = dot(movement, right), y = dot(movement, up);
    const T determinant = o.b11 * o.b22 - o.b12 * o.b21;
    const auto focused = determinant * determinant < T(1e-30);
    const T scale = select(focused, T(0), T(distance / select(focused, T(1), determinant)));
    const Vector3<T> sideways =
        sum(scaled(across[0], T(scale * (o.b22 * x - o.b12 * y))), T(scale * (o.b11 * y - o.b21 * x)), across[1]);
    return sum(sideways, dot(movement, direction), eye_direction);
}

}  // namespace equistream
