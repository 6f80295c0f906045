#pragma once
/// A parsed glTF file whose references are checked when they are followed. Internal to load_model.
#include "accessor.h"

#include "model.h"

#include <tiny_gltf.h>

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace equistream {

class GltfDocument {
public:
    /// Reads .glb or .gltf with everything it refers to. Images stay encoded.
    explicit GltfDocument(const std::filesystem::path& file);

    const std::string& file() const { return file_; }
    const tinygltf::Model& json() const { return model_; }

    /// "FILE: mesh 3"
    std::string where(const char* what, std::size_t index) const;
    /// Throws unless 0 <= index < size.
    std::size_t checked(int index, std::size_t size, const std::string& where, const char* what) const;

    Accessor accessor(int index) const;
    /// An image's file contents (PNG, JPEG ...).
    std::span<const std::uint8_t> image(int index) const;

private:
    std::span<const std::uint8_t> buffer_view(int index, const std::string& where) const;

    std::string file_;
    tinygltf::Model model_;
    std::vector<std::vector<std::uint8_t>> external_images_;  ///< those not in a buffer view, by image index
};

/// Which of a mesh's texture coordinates the textures of a material use, and what becomes of them first.
struct TextureCoordinates {
    int set = -1;  ///< TEXCOORD_SET; -1: no texture is used
    /// KHR_texture_transform: offset + rotated (scale * uv), where the rotation is counter-clockwise as seen in the
    /// picture, whose v runs down.
    glm::dvec2 offset{0}, scale{1};
    double rotation_rad = 0;

    bool operator==(const TextureCoordinates&) const = default;
    bool is_moved() const { return offset != glm::dvec2(0) || scale != glm::dvec2(1) || rotation_rad != 0; }
    glm::vec2 moved(const glm::vec2& uv) const;
};

/// Everything load_model says about materials and their textures.
struct GltfMaterials {
    std::vector<Material> materials;  ///< as many as the file has, and glTF's default at the end
    std::vector<Texture> textures;
    std::vector<AlphaMask> alpha_masks;
    std::vector<TextureCoordinates> texture_coordinates;  ///< per material
};

/// What load_model does with .glb and .gltf.
SceneModel load_gltf(const std::filesystem::path& file, const ModelOptions& options);

GltfMaterials read_materials(const GltfDocument& document, const ModelOptions& options);

/// One line on what of the file is not read, "FILE: left out: normal maps (3 materials), skins (1 skin)"; empty where
/// all is. Of shading only where the options ask for it.
std::string left_out_note(const GltfDocument& document, const ModelOptions& options);

}  // namespace equistream
