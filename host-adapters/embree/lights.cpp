#include "lights.h"

#include "directions.h"

#include <algorithm>
#include <cmath>

namespace equistream::embree_host {

SunLight::SunLight(const glm::vec3& direction, const glm::vec3& irradiance, float angular_radius_rad)
    : towards(glm::normalize(direction)), frame(towards) {
    const float radius = std::max(angular_radius_rad, 0.0002f);
    const float half_sine = std::sin(0.5f * radius), sine = std::sin(radius);
    one_minus_cos = 2 * half_sine * half_sine;
    pdf = 1 / (2 * pi_f * one_minus_cos);
    radiance = irradiance / (pi_f * sine * sine);
}

void EmitterTable::add_instance(const ShadingScene& scene, std::uint32_t index, const glm::mat4& world_from_object) {
    const Instance& instance = scene.model().instances[index];
    const Mesh& mesh = scene.model().meshes[instance.mesh];
    const auto world = [&](std::uint32_t vertex) {
        return glm::vec3(world_from_object * glm::vec4(mesh.positions[vertex], 1));
    };
    const bool mirrored = glm::determinant(glm::mat3(world_from_object)) < 0;
    const std::uint32_t mask = scene.model().mask_of(mesh);
    for (const glm::uvec3& t : mesh.triangles) {
        Triangle triangle{};
        triangle.a = world(t.x);
        triangle.ab = world(t.y) - triangle.a;
        triangle.ac = world(t.z) - triangle.a;
        triangle.mask = mask == no_index ? nullptr : &scene.model().alpha_masks[mask];
        triangle.material = scene.material_of(index);
        triangle.area = 0.5f * glm::length(glm::cross(triangle.ab, triangle.ac));
        triangle.mirrored = mirrored;
        if (!mesh.uvs.empty()) {
            triangle.uv_a = mesh.uvs[t.x];
            triangle.uv_ab = mesh.uvs[t.y] - triangle.uv_a;
            triangle.uv_ac = mesh.uvs[t.z] - triangle.uv_a;
        }
        if (triangle.area > 0)
            triangles_.push_back(triangle);
    }
}

void EmitterTable::build(ShadingScene& scene, std::span<const glm::mat4> world_from_object, const Textures& textures) {
    triangles_.clear();
    std::vector<double> brightness;
    for (ShadingMaterial& m : scene.materials()) {
        const glm::vec3 texture = m.emission_texture == no_index ? glm::vec3(1) : textures.mean(m.emission_texture);
        brightness.push_back(m.emits ? luminance(m.emission * texture) : 0);
        m.emission_pdf_area = 0;
    }
    for (std::uint32_t i = 0; i < world_from_object.size(); ++i)
        if (brightness[scene.material_of(i)] > 0)
            add_instance(scene, i, world_from_object[i]);
    std::vector<double> powers;
    double total = 0;
    for (const Triangle& triangle : triangles_) {
        powers.push_back(brightness[triangle.material] * triangle.area);
        total += powers.back();
    }
    if (triangles_.empty())
        return;
    for (std::size_t m = 0; m < brightness.size(); ++m)
        scene.materials()[m].emission_pdf_area = static_cast<float>(brightness[m] / total);
    build_alias_table(powers, total);
}

void EmitterTable::build_alias_table(const std::vector<double>& powers, double total) {
    const std::size_t n = powers.size();
    keep_.assign(n, 1);
    alias_.assign(n, 0);
    std::vector<double> share(n);
    std::vector<std::uint32_t> small, large;
    for (std::uint32_t i = 0; i < n; ++i) {
        share[i] = powers[i] / total * static_cast<double>(n);
        (share[i] < 1 ? small : large).push_back(i);
    }
    while (!small.empty() && !large.empty()) {
        const std::uint32_t s = small.back(), l = large.back();
        small.pop_back();
        keep_[s] = static_cast<float>(share[s]);
        alias_[s] = l;
        share[l] -= 1 - share[s];
        if (share[l] < 1) {
            large.pop_back();
            small.push_back(l);
        }
    }
}

EmitterSample EmitterTable::sample(float choice, const glm::vec2& u) const {
    const float scaled = choice * static_cast<float>(triangles_.size());
    std::size_t i = std::min(static_cast<std::size_t>(scaled), triangles_.size() - 1);
    if (scaled - static_cast<float>(i) >= keep_[i])
        i = alias_[i];
    const Triangle& t = triangles_[i];
    const glm::vec2 b = sample_triangle(u);
    const glm::vec3 wound = glm::normalize(glm::cross(t.ab, t.ac));
    const glm::vec2 uv = t.uv_a + b.x * t.uv_ab + b.y * t.uv_ac;
    return {t.a + b.x * t.ab + b.y * t.ac, t.mirrored ? -wound : wound, uv, t.material,
            t.mask != nullptr && !t.mask->covers(uv)};
}

}  // namespace equistream::embree_host
