#include "stage.h"

#include <scenes/generate/glowing_room.h>
#include <scenes/generate/noise.h>

#include <cmath>

namespace equistream::generate {
namespace {

constexpr int texture_side = 256;
constexpr double frames_per_second = 30;

/// Soft clouds and soft ruled lines: enough to tell a displaced pixel by, little that a source of the eyes' own density
/// could not hold, so that what a breaker breaks is not lost in what sampling loses.
ByteImage clouds_and_lines(std::uint32_t seed, glm::vec3 tint, int lines) {
    return paint(texture_side, texture_side, 3, [&](glm::vec2 at) {
        const auto cells = static_cast<float>(lines);
        const float cloud = 0.5f + 0.6f * turbulence(cells * at, lines, 2, seed);
        const float hue = 0.5f + 0.6f * turbulence(cells * at, lines, 1, seed + 1);
        const glm::vec3 colour = glm::mix(0.25f * tint, glm::mix(tint, glm::vec3(0.95f, 0.9f, 0.7f), hue), cloud);
        const glm::vec2 line = glm::abs(glm::fract(cells * at) - 0.5f);
        return glm::vec4(colour * (1 - 0.5f * glm::smoothstep(0.3f, 0.5f, std::max(line.x, line.y))), 1);
    });
}

}  // namespace

std::uint32_t painted(SceneBuilder& scene, const std::string& name, std::uint32_t seed, glm::vec3 tint) {
    constexpr int lines = 3;
    return scene.material(
        glowing(name, glm::vec3(1), scene.texture(name, clouds_and_lines(seed, tint, lines), Encoding::png)));
}

void add_stage(SceneBuilder& scene) {
    constexpr glm::vec3 tints[6] = {{0.7f, 0.5f, 0.4f}, {0.4f, 0.6f, 0.4f}, {0.4f, 0.5f, 0.7f},
                                    {0.7f, 0.6f, 0.3f}, {0.6f, 0.7f, 0.7f}, {0.5f, 0.4f, 0.5f}};
    add_glowing_room(scene, stage_size_m, [&](Side side) {
        return clouds_and_lines(100 + 10 * static_cast<std::uint32_t>(side), tints[side], 8);
    });
    const auto stone = painted(scene, "stone", 7, {0.3f, 0.35f, 0.6f});
    const auto pillar = scene.mesh("pillar", box({0.3f, 4, 0.3f}), stone);
    scene.object("pillar on the left", {pillar}, moved({-1.1f, 0, -1.9f}));
    scene.object("pillar on the right", {pillar}, moved({1.5f, 0, -2.3f}) * turned_y(0.6f));
    const auto wood = painted(scene, "wood", 8, {0.65f, 0.4f, 0.2f});
    scene.object("table", {scene.mesh("table", box({0.9f, 0.05f, 0.6f}), wood)}, moved({0.3f, -0.7f, -1.5f}));
}

void add_ball(SceneBuilder& scene, const std::string& name, glm::vec3 centre_m, float radius_m) {
    const auto mesh = scene.mesh(name, sphere(radius_m, 96, 48), painted(scene, name, 9, {0.8f, 0.25f, 0.15f}));
    scene.object(name, {mesh}, moved(centre_m));
}

GeneratedScene finished(SceneBuilder& scene, std::initializer_list<glm::dquat> heads) {
    std::vector<PosePath::Key> keys;
    for (const glm::dquat& head : heads)
        keys.push_back({static_cast<double>(keys.size()) / frames_per_second, {glm::dvec3(0), head}});
    GeneratedScene result;
    result.model = scene.finish();
    for (Material& material : result.model.materials)
        if (material.emission != glm::vec3(0))
            material.index_of_refraction = 1;  // no coat, whose reflections would be noise
    result.description.camera_path = PosePath(std::move(keys), "breaker");
    return result;
}

}  // namespace equistream::generate
