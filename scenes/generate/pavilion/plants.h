#pragma once
/// Shapes that plants are put together from.
#include "parts.h"

#include <scenes/generate/noise.h>

namespace equistream::generate::pavilion {

/// `count` folded leaf cards on and in a ball of `radius`, pointing mostly outwards; their stalks are at their bottoms.
Shape leaf_cluster(int count, float radius, glm::vec2 card_size, std::uint64_t seed);

/// A random turn and size at a place.
glm::mat4 scattered(glm::vec3 at, float scale, Random& random);

/// A card that starts at the origin, rises along +Y, and folds along its middle line.
Shape folded_leaf(float width, float length, float fold);

}  // namespace equistream::generate::pavilion
