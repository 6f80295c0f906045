#pragma once
/// What the samples of a plane may be, whoever made them. Pure; any thread.
#include <equistream/aov.h>
#include <equistream/image.h>

namespace equistream {

/// Distances (also virtual ones) are at least 0 and may be +inf, everything else is finite; of colour nothing is asked,
/// the writer takes care of it. Throws InputError naming the plane, the pixel and the value.
void require_plane_values(const AovInfo& aov, ImageView<const float> plane);

}  // namespace equistream
