#pragma once
/// Poses in the axes of another pose.
#include <equistream/camera.h>

namespace equistream {

/// A pose in the axes of `outer`, in the axes that `outer` is in.
inline Pose composed(const Pose& outer, const Pose& inner) {
    return {outer.position_m + outer.orientation * inner.position_m,
            glm::normalize(outer.orientation * inner.orientation)};
}

}  // namespace equistream
