#pragma once
/// Shadow rays: what part of a light arrives through thin glass, alpha masks and nothing else.
#include <equistream_embree/shading_scene.h>

namespace equistream::embree_host {

/// 0 where something opaque lies between, the product of the glass's tints otherwise.
glm::vec3 transmittance(const Bvh& bvh, const ShadingScene& scene, Textures::Reader& textures, const glm::vec3& origin,
                        const glm::vec3& direction, float distance);

}  // namespace equistream::embree_host
