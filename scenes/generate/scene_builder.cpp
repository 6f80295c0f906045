#include "scene_builder.h"

#include <equistream/rec709.h>

#include <cassert>

namespace equistream::generate {

std::uint32_t SceneBuilder::texture(const std::string& name, const ByteImage& image, Encoding encoding, Wrap wrap) {
    Texture texture;
    texture.name = name;
    texture.mime_type = encoding == Encoding::png ? "image/png" : "image/jpeg";
    texture.encoded = encode_image(image, encoding);
    texture.wrap_u = texture.wrap_v = wrap;
    model_.textures.push_back(std::move(texture));
    return static_cast<std::uint32_t>(model_.textures.size()) - 1;
}

std::uint32_t SceneBuilder::material(Material material) {
    model_.materials.push_back(std::move(material));
    return static_cast<std::uint32_t>(model_.materials.size()) - 1;
}

std::uint32_t SceneBuilder::masked_material(const std::string& name, const ByteImage& rgba, float roughness) {
    assert(rgba.channels() == 4);
    Material result = textured(name, texture(name, rgba, Encoding::png, Wrap::clamp), roughness);
    result.double_sided = true;
    AlphaMask mask;
    mask.width = rgba.width();
    mask.height = rgba.height();
    mask.wrap_u = mask.wrap_v = Wrap::clamp;
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 0; x < rgba.width(); ++x)
            mask.opaque.push_back(rgba.pixel(x, y)[3] >= 128 ? 255 : 0);
    model_.alpha_masks.push_back(std::move(mask));
    result.alpha_mask = static_cast<std::uint32_t>(model_.alpha_masks.size()) - 1;
    return material(std::move(result));
}

std::uint32_t SceneBuilder::mesh(const std::string& name, Shape shape, std::uint32_t material) {
    shape.name = name;
    shape.material = material;
    model_.meshes.push_back(std::move(shape));
    return static_cast<std::uint32_t>(model_.meshes.size()) - 1;
}

std::uint32_t SceneBuilder::object(const std::string& name, std::initializer_list<std::uint32_t> meshes,
                                   const glm::mat4& world_from_object) {
    const auto index = static_cast<std::uint32_t>(model_.objects.size());
    model_.objects.push_back({name, -1});
    for (const std::uint32_t mesh : meshes)
        model_.instances.push_back({mesh, index, world_from_object});
    return index;
}

void SceneBuilder::add(const std::string& name, Shape shape, std::uint32_t material) {
    object(name, {mesh(name, std::move(shape), material)});
}

Material matt(const std::string& name, glm::vec3 linear_colour, float roughness) {
    Material material;
    material.name = name;
    material.base_colour = linear_colour;
    material.metallic = 0;
    material.roughness = roughness;
    return material;
}

Material textured(const std::string& name, std::uint32_t texture, float roughness) {
    Material material = matt(name, glm::vec3(1), roughness);
    material.base_colour_texture = texture;
    return material;
}

Material metal(const std::string& name, glm::vec3 linear_colour, float roughness) {
    Material material = matt(name, linear_colour, roughness);
    material.metallic = 1;
    return material;
}

Material glass(const std::string& name, float index_of_refraction) {
    Material material = matt(name, glm::vec3(1), 0);
    material.transmission = 1;
    material.index_of_refraction = index_of_refraction;
    return material;
}

Material glowing(const std::string& name, glm::vec3 radiance, std::uint32_t texture) {
    Material material = matt(name, glm::vec3(0), 1);
    material.emission = radiance;
    material.emission_texture = texture;
    return material;
}

glm::vec3 linear_from_srgb(glm::vec3 display) {
    for (int c = 0; c < 3; ++c)
        display[c] = srgb_to_linear(display[c]);
    return display;
}

void add_glowing_room(SceneBuilder& scene, glm::vec3 size, const std::function<ByteImage(Side)>& paint_side) {
    struct Axes {
        glm::vec3 right, up;
    };
    constexpr Axes axes[] = {{{1, 0, 0}, {0, 1, 0}},  {{0, 0, 1}, {0, 1, 0}}, {{-1, 0, 0}, {0, 1, 0}},
                             {{0, 0, -1}, {0, 1, 0}}, {{1, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {0, 0, -1}}};
    for (int i = 0; i < 6; ++i) {
        const Axes& a = axes[i];
        const glm::vec3 inwards = glm::cross(a.right, a.up);
        Shape wall = card(1, 1);
        for (std::size_t k = 0; k < wall.positions.size(); ++k) {
            const glm::vec3 p = wall.positions[k];
            wall.positions[k] = size * (p.x * a.right + p.y * a.up - 0.5f * inwards);
            wall.normals[k] = inwards;
        }
        const std::string name(side_names[i]);
        const auto texture = scene.texture(name, paint_side(static_cast<Side>(i)), Encoding::png, Wrap::clamp);
        scene.add(name, std::move(wall), scene.material(glowing(name, glm::vec3(1), texture)));
    }
}

}  // namespace equistream::generate
