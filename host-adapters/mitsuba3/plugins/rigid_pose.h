#pragma once
/// Camera frames, poses and refusals that the plugins share. Between the contract's camera frame (+X right, -Z
/// forward) and Mitsuba's (+X left, +Z forward) lies half a turn about +Y, which is its own inverse.
#include <equistream/conventions.h>

#include <mitsuba/core/transform.h>
#include <tinyformat.h>

#include <stdexcept>

namespace equistream::mitsuba_host {

template <typename Vector, typename T>
Vector mitsuba_frame(const Vector3<T>& v) {
    return Vector(-v.x, v.y, -v.z);
}

template <typename T, typename Vector>
Vector3<T> contract_frame(const Vector& v) {
    return {-v.x(), v.y(), -v.z()};
}

// How the plugins refuse: one line, without the place in the source that Mitsuba's own Throw puts before it.

template <typename... Values>
[[noreturn]] void refuse(const char* format, const Values&... values) {
    throw std::runtime_error(tfm::format(format, values...));
}

// Poses as the plugins take them: a rotation and a translation, nothing else.

/// Throws one line unless `pose`, a host-side transform, turns and moves only.
template <typename Transform>
void require_rigid(const Transform& pose, const char* plugin, const char* property) {
    using Vector3 = mitsuba::Vector<double, 3>;
    const auto& m = pose.matrix;
    for (size_t i = 0; i < 4; ++i)
        for (size_t j = 0; j < 4; ++j)
            if (!drjit::isfinite(m(i, j)))
                refuse("%s: %s: expected finite numbers, found %g in row %u", plugin, property, m(i, j), i + 1);
    if (pose.has_scale())
        refuse("%s: %s: expected a rotation and a translation, found scale or shear", plugin, property);
    const auto column = [&m](size_t j) { return Vector3(m(0, j), m(1, j), m(2, j)); };
    if (drjit::dot(drjit::cross(column(0), column(1)), column(2)) < 0)
        refuse("%s: %s: expected a rotation and a translation, found a mirroring", plugin, property);
}

}  // namespace equistream::mitsuba_host
