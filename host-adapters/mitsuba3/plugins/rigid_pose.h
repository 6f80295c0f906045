#pragma once
/// Poses as the plugins take them: a rotation and a translation, nothing else.
#include "refusal.h"

#include <mitsuba/core/transform.h>

namespace equistream::mitsuba_host {

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
