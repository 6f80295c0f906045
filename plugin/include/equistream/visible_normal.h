#pragma once
/// The one definition of the normal that hosts shade with and export: interpolated or mapped normals may point away
/// from the viewer at a silhouette, where the surface itself does not. Template on the scalar as conventions.h has it;
/// C++17-clean.
#include <equistream/conventions.h>

namespace equistream {

/// Least cosine between an exported normal and the direction to the viewer.
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

/// The unit shading normal on the side of `geometric` and never edge-on to the viewer or behind; `geometric` itself if
/// `shading` has no length. `geometric` and `viewer` are unit and on the same side.
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

}  // namespace equistream
