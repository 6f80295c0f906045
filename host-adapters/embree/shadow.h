#pragma once
/// Shadow rays: what part of a light arrives through thin glass, alpha masks and nothing else.
#include "shading_scene.h"

namespace equistream::embree_host {

/// From a surface towards a light; `direction` is unit.
struct Segment {
    glm::vec3 origin, direction;
    float distance = 0;  ///< infinite for the sun
};

/// 0 where something opaque lies between, the product of the glass's tints otherwise.
glm::vec3 transmittance(const Bvh& bvh, const ShadingScene& scene, Textures::Reader& textures, const Segment& segment);

}  // namespace equistream::embree_host
