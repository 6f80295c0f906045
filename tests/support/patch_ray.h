#pragma once
/// Where the pixels of an atlas look, for tests that ask a scene themselves.
#include <equistream/patches.h>

namespace equistream {

/// Where a pixel of the atlas looks from and to, in the sphere camera's axes.
struct PatchRay {
    glm::dvec3 origin_m;   ///< from the sphere's centre
    glm::dvec3 direction;  ///< unit
};

/// Of continuous coordinates (u, v) in the slot of pixel (x, y), as patch_sphere_pixel has them. What an unused slot
/// looks at means nothing.
inline PatchRay patch_ray(const PatchAtlas& atlas, int x, int y, double u, double v) {
    const PixelCoordinates<double> at = patch_sphere_pixel(atlas, x, y, u, v);
    const glm::dvec3 origin =
        atlas.offsets_m.empty() ? glm::dvec3(0) : atlas.offsets_m[atlas.slot_at(x, y).offset_index];
    return {origin, atlas.sphere().direction(at.u, at.v)};
}

}  // namespace equistream
