#pragma once
/// From MTL's Phong model to the metal-rough one: docs/scenes.md has the table.
#include "mtl_file.h"

#include "model.h"

namespace equistream {

struct ObjMaterials {
    std::vector<Material> materials;  ///< one for each of `from`, and the one of faces without a material at the end
    std::vector<Texture> textures;
    std::vector<AlphaMask> alpha_masks;
    /// For each material, texture coordinates are scaled and moved by these (map_Kd's -s and -o).
    std::vector<glm::vec2> uv_scale, uv_offset;
    std::vector<bool> textured;  ///< something of it is looked up by texture coordinates
};

/// Textures are read only for materials that are `used`. Those that are missing, or are no images, are left out with a
/// note.
ObjMaterials convert_materials(const std::vector<MtlMaterial>& from, const std::vector<bool>& used,
                               const ModelOptions& options, ObjNotes& notes);

/// GGX roughness (glTF's, the square root of alpha) of a Phong exponent: alpha = sqrt(2 / (Ns + 2)), the Beckmann
/// width that Walter et al., "Microfacet Models for Refraction through Rough Surfaces" (EGSR 2007, section 5.2), give
/// for a Phong distribution.
float roughness_of_exponent(float ns);

}  // namespace equistream
