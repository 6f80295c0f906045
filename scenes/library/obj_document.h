#pragma once
/// An OBJ file parsed (vertices, triangles by object and material, all indices checked) and made a model. Internal to
/// load_model.
#include "mtl_file.h"

#include "model.h"

#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

/// From 0; no_index: not given.
struct ObjCorner {
    std::uint32_t position, uv, normal;
    bool operator==(const ObjCorner&) const = default;
};

/// What one material covers of one object.
struct ObjPart {
    std::uint32_t object = 0;
    std::uint32_t material = 0;                   ///< into ObjDocument::materials, or its size for none
    std::vector<ObjCorner> corners;               ///< three a triangle
    std::vector<std::uint32_t> smoothing_groups;  ///< one a triangle; 0: flat
};

struct ObjDocument {
    std::string file;
    std::vector<glm::vec3> positions, normals;
    std::vector<glm::vec2> uvs;  ///< v runs up, as in the file
    /// Objects by `o`, groups by `g` under them (at the top where there is no `o`); unlike names only.
    std::vector<Object> objects;
    std::vector<ObjPart> parts;  ///< in the order in which they begin
    std::vector<MtlMaterial> materials;
};

/// Throws InputError, FILE:LINE, for what geometry would suffer from.
ObjDocument read_obj(const std::filesystem::path& file, ObjNotes& notes);

/// What load_model does with .obj.
SceneModel load_obj(const std::filesystem::path& file, const ModelOptions& options);

}  // namespace equistream
