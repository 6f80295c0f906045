#pragma once
/// What base colours are taken to say of surfaces, and numbers of how their textures are looked up.
#include <scenes/library/model.h>
#include <scenes/library/shading_model.h>

namespace equistream {

/// Smaller triangles' textures are looked up as if they were so large.
inline constexpr float min_triangle_m2 = 1e-12f;
/// Of the angle at which a surface is seen: flatter ones' textures are looked up as if they were not.
inline constexpr float min_seen_cosine = 1e-3f;

/// False of what shines by itself, mirrors or is glass, so that its base colour says little.
inline bool is_matte(const Material& material) {
    const bool emits = glm::any(glm::greaterThan(material.emission, glm::vec3(0)));
    const bool mirrors = material.metallic > 0.5f && material.roughness < mirror_roughness;
    return !emits && !mirrors && !(material.transmission > 0.5f);
}

}  // namespace equistream
