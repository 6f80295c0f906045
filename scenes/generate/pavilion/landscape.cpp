#include "parts.h"

#include "../noise.h"

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

constexpr float tau = 6.2831853f;
constexpr float rim_radius = 70, horizon_radius = 2600;
/// North-north-east, on a hill of its own.
constexpr float tower_bearing = 9, tower_distance = 150;

/// Noise on the circle of bearings, so that it closes.
float around(glm::vec2 xz, float cell_m, int octaves, std::uint32_t seed) {
    return turbulence(xz / cell_m, 4096, octaves, seed);
}

float bump(glm::vec2 xz, glm::vec2 centre, float radius, float height) {
    const float d = glm::length(xz - centre) / radius;
    return height * std::exp(-d * d);
}

/// A sheet of ground between two radii, with radii in equal steps of their logarithm.
Shape ground_ring(float inner, float outer, int segments, int rings) {
    return sheet(
        segments, rings,
        [&](float u, float v) {
            const float radius = outer * std::pow(inner / outer, v), angle = tau * u;
            const glm::vec2 xz(radius * std::sin(angle), radius * std::cos(angle));
            return glm::vec3(xz.x, ground_height(xz), xz.y);
        },
        {1, 1}, true);
}

}  // namespace

float ground_height(glm::vec2 xz) {
    const float radius = glm::length(xz);
    const float away = glm::smoothstep(9.0f, 40.0f, radius);
    float height = lawn_height + away * 0.7f * around(xz, 18, 3, 900);
    height -= bump(xz, pond_centre, 8.5f, 1.5f);
    const float bearing = std::atan2(xz.x, -xz.y);
    // Lower towards the east, where one looks out over the lake; a ridge to the west.
    const float lift = 1 - 0.55f * std::cos(bearing - 1.6f);
    height += lift * glm::smoothstep(45.0f, 420.0f, radius) * (14 + 22 * around(xz, 260, 4, 910));
    height += lift * glm::smoothstep(500.0f, 2200.0f, radius) * (95 + 150 * std::abs(around(xz, 800, 5, 920)));
    const glm::vec3 tower = at_bearing(tower_bearing, tower_distance, 0);
    return height + bump(xz, {tower.x, tower.z}, 45, 12);
}

void build_ground(Site& site) {
    Shape lawn = ground_ring(5.9f, rim_radius, 180, 72);
    for (std::size_t i = 0; i < lawn.uvs.size(); ++i)
        lawn.uvs[i] = glm::vec2(lawn.positions[i].x, lawn.positions[i].z) / 4.0f;
    site.scene.add("lawn", std::move(lawn), site.paint.lawn);
    Shape land = ground_ring(rim_radius, horizon_radius, 180, 64);
    for (glm::vec2& uv : land.uvs)
        uv.y = 0.998f * (1 - uv.y) + 0.001f;
    site.scene.add("far land", std::move(land), site.paint.far_land);
    Shape water = ring(0, 16, 96);
    site.scene.object("lake", {site.scene.mesh("lake", std::move(water), site.paint.water)},
                      moved({pond_centre.x, water_height, pond_centre.y}));
}

/// Flags from the southern and northern way in, and two finger posts.
void build_path_and_signs(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(7);
    const Shape flag = bevelled_box({1, 0.1f, 1}, 0.015f);
    const auto mesh = scene.mesh("flag", flag, site.paint.paving);
    for (const float way : {180.0f, 0.0f})
        for (int row = 0; row < 11; ++row)
            for (int side = -1; side <= 1; side += 2) {
                const float radius = 6.62f + 0.78f * static_cast<float>(row);
                const float width = random.between(0.62f, 0.8f);
                const glm::vec3 offset(static_cast<float>(side) * 0.43f + random.between(-0.02f, 0.02f), 0, 0);
                scene.object("flag", {mesh},
                             placed(way, radius, lawn_height - 0.025f) * moved(offset) *
                                 turned_y(random.between(-0.05f, 0.05f)) *
                                 glm::scale(glm::mat4(1), glm::vec3(width, 1, random.between(0.62f, 0.72f))));
            }
    const auto post = scene.mesh("post", plank({2.3f, 0.09f, 0.09f}), site.paint.wood);
    const glm::mat4 upright = glm::rotate(glm::mat4(1), tau / 4, glm::vec3(0, 0, 1));
    const auto sign = [&](const std::string& name, float bearing, float radius, std::uint32_t material) {
        const glm::mat4 here = placed(bearing, radius, lawn_height);
        scene.object("post", {post}, here * moved({0, 1.0f, 0}) * upright);
        scene.object(name + " board", {scene.mesh("board", plank({1.04f, 0.29f, 0.03f}), site.paint.wood)},
                     here * moved({0, 1.85f, 0.062f}));
        scene.object(name, {scene.mesh(name, card(1, 0.25f), material)}, here * moved({0, 1.85f, 0.08f}));
    };
    sign("sign to the tower", 337, 7.6f, site.paint.sign_north);
    sign("sign to the lake", 62, 7.4f, site.paint.sign_east);
}

/// A round stone tower with a tiled roof on a northern hill.
void build_tower(Site& site) {
    const glm::vec3 foot = at_bearing(tower_bearing, tower_distance, 0);
    const float base = ground_height({foot.x, foot.z}) - 1;
    constexpr std::array<glm::vec2, 8> wall{
        {{4.4f, 0}, {4, 2}, {3.7f, 15}, {4.5f, 16.2f}, {4.5f, 18}, {4, 18}, {4, 19.5f}, {3.5f, 19.5f}}};
    constexpr std::array<glm::vec2, 4> roof{{{3.5f, 19.2f}, {4.9f, 19.2f}, {2, 24}, {0, 28.5f}}};
    Shape windows;
    for (int i = 0; i < 8; ++i)
        append(windows, box({0.9f, 1.9f, 0.5f}),
               turned_y(tau * static_cast<float>(i) / 8) * moved({0, 7 + 2.4f * static_cast<float>(i % 3), 3.75f}));
    const glm::mat4 here = moved({foot.x, base, foot.z});
    SceneBuilder& scene = site.scene;
    scene.object("tower",
                 {scene.mesh("tower wall", lathe(wall, 48), site.paint.limestone),
                  scene.mesh("tower roof", lathe(roof, 48), site.paint.terracotta),
                  scene.mesh("tower windows", std::move(windows), site.paint.iron)},
                 here);
}

}  // namespace equistream::generate::pavilion
