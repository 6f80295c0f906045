#include "parts.h"

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

Shape pot() {
    constexpr glm::vec2 outline[] = {{0, 0},          {0.15f, 0},       {0.155f, 0.01f},  {0.215f, 0.33f},
                                     {0.24f, 0.335f}, {0.245f, 0.345f}, {0.245f, 0.405f}, {0.238f, 0.413f},
                                     {0.21f, 0.413f}, {0.2f, 0.405f},   {0.19f, 0.35f}};
    return lathe(outline, 64);
}

/// A leaf that rises and arches over: `reach` out, its highest point at `height`.
Shape arching_leaf(float width, float reach, float height) {
    return v_turned(sheet(4, 14, [&](float u, float v) {
        const float across = u - 0.5f;
        const float rise = height * std::sin(0.62f * tau / 2 * v) / std::sin(0.62f * tau / 4) * (1 - 0.18f * v);
        const float out = reach * (0.25f * v + 0.75f * v * v);
        return glm::vec3(-across * width, rise + 0.35f * width * std::abs(across), out);
    }));
}

/// A blade of grass bent outwards.
void add_blade(Shape& patch, glm::vec3 at, float height, Random& random) {
    const float a = tau * random.uniform(), lean = height * random.between(0.15f, 0.6f),
                width = 0.007f + 0.02f * height;
    const glm::vec3 out(std::cos(a), 0, std::sin(a)), across(-out.z, 0, out.x);
    const Shape blade = sheet(1, 2, [&](float u, float v) {
        return at + out * (lean * v * v) + glm::vec3(0, height * v * (1 - 0.25f * v), 0) +
               across * (width * (u - 0.5f) * (1 - 0.95f * v));
    });
    append(patch, blade);
}

Shape grass_patch(int count, float radius, std::uint64_t seed) {
    Random random(seed);
    Shape patch;
    for (int i = 0; i < count; ++i) {
        const float a = tau * random.uniform(), r = radius * std::sqrt(random.uniform());
        add_blade(patch, {r * std::cos(a), -0.015f, r * std::sin(a)}, random.between(0.05f, 0.16f), random);
    }
    return patch;
}

/// A handful of flowers: stalks (blades) and five petals each.
struct Flowers {
    Shape stalks, petals;
};
Flowers flower_patch(std::uint64_t seed) {
    Random random(seed);
    Flowers flowers;
    const Shape petal = folded_leaf(0.03f, 0.036f, 0.3f);
    for (int i = 0; i < 13; ++i) {
        const float a = tau * random.uniform(), r = 0.28f * std::sqrt(random.uniform()),
                    height = random.between(0.14f, 0.3f);
        const glm::vec3 foot(r * std::cos(a), -0.015f, r * std::sin(a));
        const glm::vec3 head = foot + glm::vec3(random.between(-0.04f, 0.04f), height, random.between(-0.04f, 0.04f));
        append(flowers.stalks, tube(std::array{foot, head}, std::array{0.003f, 0.002f}, 5));
        for (int k = 0; k < 2; ++k)
            add_blade(flowers.stalks, foot, 0.6f * height, random);
        const glm::mat4 tilt = moved(head) * glm::rotate(glm::mat4(1), random.between(-0.5f, 0.5f), glm::vec3(1, 0, 0));
        for (int k = 0; k < 6; ++k)
            append(flowers.petals, petal,
                   tilt * turned_y(tau * static_cast<float>(k) / 6) *
                       glm::rotate(glm::mat4(1), 1.0f, glm::vec3(1, 0, 0)));
    }
    return flowers;
}

bool on_path(glm::vec3 at) {
    return std::abs(at.x) < 1.15f && std::abs(at.z) > 6;
}

}  // namespace

/// Grass and flowers around the steps, thinning out.
void build_meadow(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(41);
    const std::array grass{scene.mesh("grass a", grass_patch(46, 0.42f, 42), site.paint.blade_green),
                           scene.mesh("grass b", grass_patch(40, 0.4f, 43), site.paint.blade_green),
                           scene.mesh("grass c", grass_patch(30, 0.38f, 44), site.paint.blade_straw)};
    const auto somewhere = [&](float reach) {
        const float radius = 6.55f + reach * random.uniform() * random.uniform();
        const glm::vec3 at = at_bearing(random.between(0, 360), radius, 0);
        return glm::vec3(at.x, ground_height({at.x, at.z}), at.z);
    };
    for (int i = 0; i < 380; ++i) {
        const glm::vec3 at = somewhere(11);
        if (!on_path(at))
            scene.object("grass", {grass[i % 7 == 0 ? 2 : i % 2]},
                         moved(at) * turned_y(tau * random.uniform()) *
                             glm::scale(glm::mat4(1), glm::vec3(random.between(0.85f, 1.3f))));
    }
    const Flowers flowers = flower_patch(45);
    const auto stalks = scene.mesh("stalks", flowers.stalks, site.paint.blade_green);
    const std::array petals{scene.mesh("red petals", flowers.petals, site.paint.petal_red),
                            scene.mesh("white petals", flowers.petals, site.paint.petal_white),
                            scene.mesh("blue petals", flowers.petals, site.paint.petal_blue)};
    for (int i = 0; i < 105; ++i) {
        const glm::vec3 at = somewhere(5);
        // Colours by quarter: red north, white east and west, blue south.
        const std::size_t colour = at.z < -3.5f ? 0 : at.z > 3.5f ? 2 : 1;
        if (!on_path(at))
            scene.object("flowers", {stalks, petals[colour]}, moved(at) * turned_y(tau * random.uniform()));
    }
}

/// Two plants with long arching leaves beside the walk, one leaf before the walker's eyes; round shrubs elsewhere.
void build_pots(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(51);
    const auto pot_mesh = scene.mesh("pot", pot(), site.paint.terracotta);
    const auto soil = scene.mesh("soil", ring(0, 0.2f, 48), site.paint.soil);
    const auto place_pot = [&](glm::vec3 at) {
        scene.object("pot", {pot_mesh}, moved(at));
        scene.object("soil", {soil}, moved(at + glm::vec3(0, 0.37f, 0)));
    };
    const std::array leaves{scene.mesh("long leaf", arching_leaf(0.2f, 0.72f, 1.18f), site.paint.long_leaf),
                            scene.mesh("longer leaf", arching_leaf(0.24f, 0.6f, 1.32f), site.paint.long_leaf),
                            scene.mesh("low leaf", arching_leaf(0.2f, 0.85f, 0.7f), site.paint.long_leaf)};
    for (const glm::vec3 at : {glm::vec3(-2.5f, 0, 1.75f), glm::vec3(2.9f, 0, 2.2f), glm::vec3(2.2f, 0, -3.45f)}) {
        place_pot(at);
        for (int i = 0; i < 13; ++i) {
            const float turn = tau * static_cast<float>(i) / 13 + random.between(-0.15f, 0.15f);
            scene.object("long leaf", {leaves[static_cast<std::size_t>(i % 3)]},
                         moved(at + glm::vec3(0, 0.36f, 0)) * turned_y(turn) * moved({0, 0, 0.03f}) *
                             glm::scale(glm::mat4(1), glm::vec3(random.between(0.88f, 1.0f))));
        }
    }
    const auto shrub = scene.mesh("shrub leaves", leaf_cluster(40, 0.2f, {0.15f, 0.17f}, 52), site.paint.twig_leaf);
    constexpr glm::vec2 stem[] = {{0.02f, 0.3f}, {0.014f, 0.95f}};
    const auto stem_mesh = scene.mesh("shrub stem", lathe(stem, 10), site.paint.bark);
    for (const float bearing : {150.0f, 240.0f, 272.0f, 88.0f, 330.0f}) {
        const glm::vec3 at = at_bearing(bearing, bearing == 330 || bearing == 150 ? 5.0f : 3.85f, 0);
        place_pot(at);
        scene.object("shrub stem", {stem_mesh}, moved(at));
        for (int i = 0; i < 9; ++i) {
            const float a = 2.4f * static_cast<float>(i);
            const glm::vec3 offset(0.17f * std::cos(a), 0.95f + 0.05f * static_cast<float>(i % 4), 0.17f * std::sin(a));
            scene.object("shrub", {shrub}, scattered(at + offset, random.between(0.85f, 1.1f), random));
        }
    }
}

/// What grows in the glass ball.
void build_terrarium(Site& site) {
    constexpr float inside = glass_ball_radius - 0.012f, soil_rad = -0.5f;
    std::vector<glm::vec2> earth;
    for (int i = 0; i <= 12; ++i) {
        const float a = glm::mix(-0.25f * tau, soil_rad, static_cast<float>(i) / 12);
        earth.emplace_back(i == 0 ? 0 : inside * std::cos(a), inside * std::sin(a));
    }
    const float ground = inside * std::sin(soil_rad);
    earth.emplace_back(0, ground + 0.015f);
    SceneBuilder& scene = site.scene;
    const glm::mat4 here = moved(glass_ball_centre);
    scene.object("earth", {scene.mesh("earth", lathe(earth, 48), site.paint.soil)}, here);
    const std::array stem{glm::vec3(0, ground, 0), glm::vec3(0.012f, 0.5f * ground, 0.004f), glm::vec3(0, 0.03f, 0)};
    const auto wood = scene.mesh("orange stem", tube(stem, std::array{0.009f, 0.007f, 0.005f}, 10), site.paint.bark);
    const auto leaves =
        scene.mesh("orange leaves", leaf_cluster(44, 0.085f, {0.06f, 0.068f}, 55), site.paint.twig_leaf);
    scene.object("orange tree", {wood, leaves}, here * moved({0, 0.04f, 0}));
    const auto fruit = scene.mesh("small orange", sphere(0.013f, 16, 8), site.paint.orange);
    for (int i = 0; i < 7; ++i) {
        const float a = 2.4f * static_cast<float>(i), y = 0.03f * static_cast<float>(i % 4) - 0.03f;
        scene.object("small orange", {fruit}, here * moved({0.095f * std::cos(a), 0.04f + y, 0.095f * std::sin(a)}));
    }
}

/// Ivy up two western columns and along the rafters, and tendrils that hang beside the walker's head.
void build_vines(Site& site) {
    SceneBuilder& scene = site.scene;
    Random random(61);
    const std::array ivy{scene.mesh("ivy a", leaf_cluster(16, 0.13f, {0.11f, 0.12f}, 62), site.paint.ivy_leaf),
                         scene.mesh("ivy b", leaf_cluster(12, 0.11f, {0.12f, 0.13f}, 63), site.paint.ivy_leaf)};
    const auto put = [&](glm::vec3 at, float scale) {
        scene.object("ivy", {ivy[random.bits() % 2]}, scattered(at, scale, random));
    };
    for (const float bearing : {285.0f, 315.0f}) {
        const glm::vec3 foot = at_bearing(bearing, column_ring_radius, 0);
        for (int i = 0; i < 46; ++i) {
            const float t = static_cast<float>(i) / 45, a = 0.62f * static_cast<float>(i) + bearing;
            const float radius = 0.27f + random.between(-0.02f, 0.04f);
            put(foot + glm::vec3(radius * std::cos(a), 0.2f + 2.95f * t, radius * std::sin(a)),
                random.between(0.8f, 1.15f));
        }
    }
    for (int rafter = 0; rafter < 4; ++rafter)
        for (int i = 0; i < 16; ++i) {
            const float bearing = 277.5f + 15 * static_cast<float>(rafter);
            const float radius =
                glm::mix(5.0f, 1.5f + 0.5f * static_cast<float>(rafter % 2), static_cast<float>(i) / 15);
            put(at_bearing(bearing + random.between(-2, 2), radius, rafter_bottom + random.between(0.02f, 0.3f)),
                random.between(0.9f, 1.5f));
        }
    // Each tendril: where it hangs and how low.
    struct Tendril {
        float bearing, radius, bottom;
    };
    constexpr Tendril tendrils[] = {{292.5f, 1.98f, 1.52f}, {292.5f, 2.35f, 2.3f}, {307.5f, 2.5f, 2.0f},
                                    {277.5f, 2.9f, 2.35f},  {307.5f, 3.3f, 2.5f},  {322.5f, 2.2f, 2.2f}};
    const Shape leaf = folded_leaf(0.085f, 0.09f, 0.25f);
    for (const Tendril& tendril : tendrils) {
        const glm::vec3 top = at_bearing(tendril.bearing, tendril.radius, rafter_bottom);
        const int steps = static_cast<int>((rafter_bottom - tendril.bottom) / 0.075f);
        std::vector<glm::vec3> line;
        Shape leaves;
        for (int i = 0; i <= steps; ++i) {
            const float d = 0.075f * static_cast<float>(i);
            line.push_back(top +
                           glm::vec3(0.03f * std::sin(2.2f * d + tendril.radius), -d, 0.03f * std::sin(3.1f * d)));
            if (i < 3)
                continue;
            const glm::mat4 turn = moved(line.back()) *
                                   turned_y(2.2f * static_cast<float>(i) + random.between(-0.4f, 0.4f)) *
                                   glm::rotate(glm::mat4(1), random.between(1.7f, 2.4f), glm::vec3(1, 0, 0));
            append(leaves, leaf, turn * glm::scale(glm::mat4(1), glm::vec3(random.between(0.8f, 1.15f))));
        }
        const std::vector<float> radii(line.size(), 0.0025f);
        scene.object("tendril", {scene.mesh("tendril stem", tube(line, radii, 6), site.paint.bark),
                                 scene.mesh("tendril leaves", std::move(leaves), site.paint.ivy_leaf)});
    }
}

}  // namespace equistream::generate::pavilion
