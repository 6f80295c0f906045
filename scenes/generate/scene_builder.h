#pragma once
/// Puts a SceneModel together by name: textures and materials, meshes, objects that place them.
#include "paint.h"
#include "shapes.h"

#include <scenes/library/model.h>

#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <initializer_list>
#include <string>
#include <string_view>

namespace equistream::generate {

class SceneBuilder {
public:
    std::uint32_t texture(const std::string& name, const ByteImage& image, Encoding encoding = Encoding::jpeg,
                          Wrap wrap = Wrap::repeat);
    std::uint32_t material(Material material);
    Material& at(std::uint32_t material) { return model_.materials[material]; }
    /// A dielectric whose texture's alpha (cut at 1/2) says where there is anything at all; seen from both sides.
    std::uint32_t masked_material(const std::string& name, const ByteImage& rgba, float roughness);
    std::uint32_t mesh(const std::string& name, Shape shape, std::uint32_t material);
    std::uint32_t object(const std::string& name, std::initializer_list<std::uint32_t> meshes,
                         const glm::mat4& world_from_object = glm::mat4(1));
    /// A mesh placed once, where it was made.
    void add(const std::string& name, Shape shape, std::uint32_t material);

    SceneModel finish() { return std::move(model_); }

private:
    SceneModel model_;
};

/// A plain dielectric.
Material matt(const std::string& name, glm::vec3 linear_colour, float roughness = 0.9f);
/// The same with a texture.
Material textured(const std::string& name, std::uint32_t texture, float roughness = 0.9f);
Material metal(const std::string& name, glm::vec3 linear_colour, float roughness);
Material glass(const std::string& name, float index_of_refraction = 1.5f);
/// Light and nothing else: black under any lamp.
Material glowing(const std::string& name, glm::vec3 radiance, std::uint32_t texture = no_index);

/// Display-referred sRGB to linear Rec.709, per channel.
glm::vec3 linear_from_srgb(glm::vec3 display);

inline glm::mat4 moved(glm::vec3 by) {
    return glm::translate(glm::mat4(1), by);
}
inline glm::mat4 turned_y(float angle_rad) {
    return glm::rotate(glm::mat4(1), angle_rad, glm::vec3(0, 1, 0));
}

// A box seen from inside whose six sides glow with a painted texture each: renders without noise.

/// Sides as met by someone who looks along -Z and turns right, then looks up and down from there.
enum Side { ahead, right, behind, left, above, below };
inline constexpr std::array<std::string_view, 6> side_names{"ahead", "right", "behind", "left", "above", "below"};

/// Texture x runs to the right and y down as seen from inside (above and below: as seen when tilting from ahead).
void add_glowing_room(SceneBuilder& scene, glm::vec3 size, const std::function<ByteImage(Side)>& paint_side);

}  // namespace equistream::generate
