#pragma once
/// A scene's geometry and materials as read from glTF 2.0 / GLB or Wavefront OBJ / MTL. Host and client both use it:
/// the client asks for geometry and alpha masks only. Everything is owned by the SceneModel; concurrent reads are safe.
#include <glm/glm.hpp>

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace equistream {

inline constexpr std::uint32_t no_index = 0xffffffffu;

/// One glTF primitive, or what one material of an OBJ's object or group covers: an indexed triangle list. `normals` and
/// `uvs` are empty or as long as `positions`.
struct Mesh {
    std::string name;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;
    std::vector<glm::vec2> uvs;  ///< v runs down, as in glTF
    std::vector<glm::uvec3> triangles;
    std::uint32_t material = no_index;
};

/// One placement of one mesh. `object` numbers the glTF node (OBJ: object or group) it came from; a node's primitives
/// share it.
struct Instance {
    std::uint32_t mesh = no_index;
    std::uint32_t object = 0;
    glm::mat4 world_from_object{1};
};

struct Object {
    std::string name;
    int parent = -1;
    glm::mat4 world_from_object{1};
};

enum class Wrap : std::uint8_t { repeat, clamp, mirror };

/// An image as it lies in the file: still encoded (PNG, JPEG; from an OBJ's MTL also TGA, BMP, DDS and whatever else
/// pictures/encoded_image.h opens), to be decoded by whoever needs it.
struct Texture {
    std::string name;       ///< the file's, where it came from one: its extension tells a format without a signature
    std::string mime_type;  ///< glTF's; empty from an OBJ
    std::vector<std::uint8_t> encoded;
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    bool nearest = false;
};

/// Coverage of an alpha-masked material's texture, one byte a texel: 255 opaque, 0 cut away (the cutoff applied).
struct AlphaMask {
    int width = 0;
    int height = 0;
    Wrap wrap_u = Wrap::repeat;
    Wrap wrap_v = Wrap::repeat;
    std::vector<std::uint8_t> opaque;

    /// Nearest texel at glTF texture coordinates.
    bool covers(glm::vec2 uv) const;
    /// Whether anything is cut away.
    bool cuts() const;
};

struct Material {
    std::string name;
    glm::vec3 base_colour{1};
    std::uint32_t base_colour_texture = no_index;
    float metallic = 1;
    float roughness = 1;
    std::uint32_t metallic_roughness_texture = no_index;  ///< G roughness, B metallic
    glm::vec3 emission{0};                                ///< radiance factor, KHR_materials_emissive_strength applied
    std::uint32_t emission_texture = no_index;
    float transmission = 0;
    float index_of_refraction = 1.5f;
    bool double_sided = false;
    std::uint32_t alpha_mask = no_index;  ///< into SceneModel::alpha_masks; set for alphaMode MASK
};

struct SceneModel {
    std::filesystem::path file;  ///< where it was read from, for errors; empty if it was made in memory
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;
    std::vector<Object> objects;
    std::vector<Material> materials;  ///< never empty; a mesh without one uses the last, glTF's default
    std::vector<Texture> textures;
    std::vector<AlphaMask> alpha_masks;
    /// What the reader made do with (a missing texture, an unknown material), one line each, "FILE:LINE: ...": for a
    /// program to show on stderr.
    std::vector<std::string> notes;

    /// The alpha mask that cuts into a mesh, no_index if none does: its material has none, or the mesh has no texture
    /// coordinates to look it up with.
    std::uint32_t mask_of(const Mesh& mesh) const;
    std::uint64_t triangle_count() const;         ///< with instances
    std::uint64_t unique_triangle_count() const;  ///< without
};

struct ModelOptions {
    bool shading =
        true;  ///< false: positions, triangles, uvs of masked materials and their masks only (the client's share)
};

/// Reads .glb or .gltf, or .obj with the MTL files it names. Unknown required extensions, missing buffers, truncated
/// files and out-of-range indices throw InputError naming the file (of an OBJ the line too) and what was found; a model
/// without a triangle is an error too. What merely looks worse than meant is a note.
SceneModel load_model(const std::filesystem::path& file, const ModelOptions& options = {});

/// Scales all placements about the origin, from units of `unit_m` metres to metres. Throws InputError where coordinates
/// leave their limits.
void scale_model(SceneModel& model, double unit_m);

// From an encoded image to an AlphaMask.

struct MaskImage {
    std::span<const std::uint8_t> encoded;  ///< what pictures/encoded_image.h opens
    std::string name;                       ///< the file's: its extension may tell the format
    std::string where;                      ///< for errors
    float alpha_factor = 1;
    float cutoff = 0.5f;
    bool grey_is_alpha = false;  ///< where the image has no alpha, or nothing but opaque: the first channel
};

/// Decodes the image and keeps where alpha * `alpha_factor` >= `cutoff`. Images without alpha cover everything that the
/// factor alone covers. InputError names `where` and what the decoder said.
AlphaMask decode_alpha_mask(const MaskImage& image);

/// Covers nothing or everything: an alpha-masked material without a texture.
AlphaMask constant_alpha_mask(bool opaque);

// What every renderer of our scenes takes a material and a render to be, unless told otherwise; the formulas
// themselves are each renderer's.

/// Below this roughness a surface is a mirror.
inline constexpr float mirror_roughness = 0.03f;

/// Scatterings of a path at most, straight passes through glass not counted.
inline constexpr std::uint32_t default_max_bounces = 8;

}  // namespace equistream
