#include "parts.h"

#include <scenes/generate/paint.h>

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

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
    const float lift = 1 - 0.35f * std::cos(bearing - 1.6f);
    height += lift * glm::smoothstep(45.0f, 420.0f, radius) * (19 + 34 * around(xz, 230, 4, 910));
    height += lift * glm::smoothstep(500.0f, 2200.0f, radius) * (130 + 330 * std::abs(around(xz, 760, 5, 920)));
    const glm::vec3 tower = at_bearing(tower_bearing, tower_distance, 0);
    return height + bump(xz, {tower.x, tower.z}, 45, 12);
}

void build_ground(Site& site) {
    Shape lawn = ground_ring(5.9f, rim_radius, 160, 64);
    for (std::size_t i = 0; i < lawn.uvs.size(); ++i)
        lawn.uvs[i] = glm::vec2(lawn.positions[i].x, lawn.positions[i].z) / 5.0f;
    site.scene.add("lawn", std::move(lawn), site.paint.lawn);
    Shape land = ground_ring(rim_radius, horizon_radius, 180, 56);
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
    constexpr glm::vec2 wall[] = {{4.4f, 0},  {4, 2},  {3.7f, 15}, {4.5f, 16.2f},
                                  {4.5f, 18}, {4, 18}, {4, 19.5f}, {3.5f, 19.5f}};
    constexpr glm::vec2 roof[] = {{3.5f, 19.2f}, {4.9f, 19.2f}, {2, 24}, {0, 28.5f}};
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

/// A small boat with a patched sail on the lake.
void build_boat(Site& site) {
    Shape hull = sheet(24, 8, [](float u, float v) {
        const float along = 2 * u - 1, across = 2 * v - 1;
        const float beam = 0.62f * std::pow(1 - std::pow(std::abs(along), 2.6f), 0.8f);
        const float depth = 0.42f * (1 - across * across) * (1 - 0.5f * along * along);
        return glm::vec3(1.7f * along, 0.38f + 0.16f * along * along - depth, beam * across);
    });
    Shape inner = hull;
    for (glm::vec3& p : inner.positions)
        p = p * glm::vec3(0.97f, 1, 0.95f) + glm::vec3(0, 0.03f, 0);
    append(hull, inside_out(inner));
    append(hull, plank({0.25f, 0.03f, 1.05f}), moved({-0.45f, 0.27f, 0}));
    append(hull, tube(std::array{glm::vec3(0.3f, 0, 0), glm::vec3(0.3f, 3.1f, 0)}, std::array{0.035f, 0.02f}, 12));
    append(hull,
           tube(std::array{glm::vec3(0.3f, 0.75f, 0), glm::vec3(-1.35f, 0.8f, 0.3f)}, std::array{0.022f, 0.018f}, 10));
    const Shape sail = sheet(10, 14, [](float u, float v) {
        const glm::vec3 foot = glm::mix(glm::vec3(0.26f, 0.8f, 0), glm::vec3(-1.3f, 0.85f, 0.29f), u * (1 - v));
        return foot + glm::vec3(0, 2.15f * v, 0.35f * std::sin(3.14159f * u * (1 - v)) * (1 - v));
    });
    SceneBuilder& scene = site.scene;
    scene.object("boat",
                 {scene.mesh("hull", std::move(hull), site.paint.wood), scene.mesh("sail", sail, site.paint.sail)},
                 moved({pond_centre.x - 1.5f, water_height - 0.06f, pond_centre.y + 0.5f}) * turned_y(0.9f));
}

/// Heaps of cumulus: lumpy balls with level bottoms, far up.
void build_clouds(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(71);
    std::array<std::uint32_t, 2> meshes{};
    for (std::size_t kind = 0; kind < meshes.size(); ++kind) {
        Shape cloud;
        for (int i = 0; i < 8; ++i) {
            const float along = random.between(-1, 1);
            const glm::vec3 centre(95 * along, random.between(0, 34) * (1 - along * along), random.between(-28, 28));
            const float size = random.between(30, 52) * (1 - 0.45f * along * along);
            const Shape ball = sphere(1, 26, 13);
            Shape lump = sheet(
                26, 13,
                [&](float u, float v) {
                    const std::size_t k = static_cast<std::size_t>(std::lround(v * 13) * 27 + std::lround(u * 26));
                    const glm::vec3 d = ball.positions[k];
                    const float swell =
                        turbulence(glm::vec2(1.7f * d.x + d.z, 1.7f * d.y - 0.6f * d.z) + along * 9.0f, 4096, 3, 72);
                    glm::vec3 p = centre + size * (1 + 0.28f * swell) * d;
                    p.y = p.y < -8 ? -8 + 0.15f * (p.y + 8) : p.y;
                    return p;
                },
                {1, 1}, true);
            append(cloud, lump);
        }
        meshes[kind] = scene.mesh("cloud", std::move(cloud), site.paint.cloud);
    }
    // Opposite the sun, where they show their lit side.
    constexpr std::array<float, 6> bearings{8, 35, 62, 90, 120, 340};
    for (std::size_t i = 0; i < bearings.size(); ++i) {
        scene.object("cloud", {meshes[i % 2]},
                     placed(bearings[i], random.between(650, 1300), random.between(520, 760)) *
                         turned_y(random.between(-0.5f, 0.5f)) *
                         glm::scale(glm::mat4(1), glm::vec3(random.between(1.1f, 2.0f))));
    }
}

}  // namespace equistream::generate::pavilion
