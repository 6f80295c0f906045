#include "paintwork.h"

#include <scenes/generate/paint.h>

#include <cmath>

namespace equistream::generate::pavilion {
namespace {

Material plain(const std::string& name, glm::vec3 display_colour, float roughness = 0.9f) {
    return matt(name, linear_from_srgb(display_colour), roughness);
}

Material seen_from_both_sides(Material material) {
    material.double_sided = true;
    return material;
}

void add_stone_and_wood(SceneBuilder& scene, Paintwork& p) {
    p.tiles = scene.material(textured("marble tiles", scene.texture("tiles", paint_tiles()), 0.22f));
    p.medallion = scene.material(
        textured("medallion", scene.texture("medallion", paint_medallion(), Encoding::jpeg, Wrap::clamp), 0.22f));
    p.dark_marble = scene.material(textured("dark marble", scene.texture("dark marble", paint_dark_marble()), 0.2f));
    p.limestone = scene.material(textured("limestone", scene.texture("limestone", paint_limestone()), 0.8f));
    p.wood = scene.material(textured("wood", scene.texture("wood", paint_wood()), 0.55f));
    p.paving = scene.material(textured("paving", scene.texture("paving", paint_paving()), 0.85f));
    p.terracotta = scene.material(plain("terracotta", {0.72f, 0.42f, 0.29f}));
    p.soil = scene.material(plain("soil", {0.2f, 0.14f, 0.1f}));
}

void add_metal_and_glass(SceneBuilder& scene, Paintwork& p) {
    p.iron = scene.material(plain("wrought iron", {0.13f, 0.14f, 0.15f}, 0.45f));
    p.brass = scene.material(metal("brass", {0.88f, 0.7f, 0.36f}, 0.28f));
    p.copper = scene.material(metal("copper", {0.93f, 0.6f, 0.46f}, 0.24f));
    p.mirror = scene.material(metal("mirror", {0.95f, 0.95f, 0.95f}, 0));
    Material bell_glass = glass("tinted glass");  // thin-walled: without a volume glTF's glass does not refract
    bell_glass.base_colour = {0.8f, 0.93f, 0.9f};
    p.tinted_glass = scene.material(bell_glass);
    p.lamp = scene.material(glowing("lamp", {14, 7.5f, 2.4f}));
}

void add_things(SceneBuilder& scene, Paintwork& p) {
    p.china = scene.material(plain("china", {0.86f, 0.88f, 0.9f}, 0.15f));
    p.tea = scene.material(plain("tea", {0.42f, 0.2f, 0.08f}, 0.05f));
    p.orange = scene.material(plain("orange", {0.93f, 0.52f, 0.1f}, 0.4f));
    p.sail = scene.material(seen_from_both_sides(plain("sail", {0.93f, 0.88f, 0.78f})));
    p.cloud = scene.material(plain("cloud", {0.97f, 0.97f, 0.97f}, 1));
    p.book = scene.material(plain("book", {0.16f, 0.29f, 0.5f}, 0.5f));
    p.beach_ball =
        scene.material(textured("beach ball", scene.texture("beach ball", paint_beach_ball(), Encoding::png), 0.35f));
    for (int i = 0; i < 4; ++i) {
        const std::string name = "banner " + std::to_string(i + 1);
        const auto cloth = scene.texture(name, paint_banner(i), Encoding::png, Wrap::clamp);
        p.banners[i] = scene.material(seen_from_both_sides(textured(name, cloth, 1)));
    }
    p.sign_north = scene.material(textured(
        "sign north", scene.texture("sign north", paint_sign("TOWER", false), Encoding::png, Wrap::clamp), 0.6f));
    p.sign_east = scene.material(
        textured("sign east", scene.texture("sign east", paint_sign("LAKE", true), Encoding::png, Wrap::clamp), 0.6f));
}

void add_nature(SceneBuilder& scene, Paintwork& p) {
    p.lawn = scene.material(textured("lawn", scene.texture("lawn", paint_lawn()), 1));
    p.far_land = scene.material(textured("far land", scene.texture("far land", paint_far_land()), 1));
    p.water = scene.material(plain("water", {0.1f, 0.2f, 0.22f}, 0.03f));
    p.bark = scene.material(textured("bark", scene.texture("bark", paint_bark()), 1));
    p.blade_green = scene.material(seen_from_both_sides(plain("grass blades", {0.38f, 0.5f, 0.16f})));
    p.blade_straw = scene.material(seen_from_both_sides(plain("dry blades", {0.56f, 0.55f, 0.27f})));
    p.petal_red = scene.material(seen_from_both_sides(plain("red petals", {0.8f, 0.13f, 0.12f})));
    p.petal_white = scene.material(seen_from_both_sides(plain("white petals", {0.92f, 0.9f, 0.84f})));
    p.petal_blue = scene.material(seen_from_both_sides(plain("blue petals", {0.36f, 0.34f, 0.78f})));
    p.twig_leaf = scene.masked_material("twigs", paint_twig(), 0.7f);
    p.ivy_leaf = scene.masked_material("ivy", paint_ivy_leaf(), 0.5f);
    p.long_leaf = scene.masked_material("long leaves", paint_long_leaf(), 0.45f);
    p.cypress_leaf = scene.masked_material("cypress", paint_cypress(), 0.9f);
}

}  // namespace

Paintwork paint_all(SceneBuilder& scene) {
    Paintwork p{};
    add_stone_and_wood(scene, p);
    add_metal_and_glass(scene, p);
    add_things(scene, p);
    add_nature(scene, p);
    return p;
}

namespace {

struct Banner {
    glm::vec3 field, charge;
    char letter;
};
constexpr Banner banners[] = {{{0.13f, 0.25f, 0.55f}, {0.95f, 0.85f, 0.5f}, 'N'},
                              {{0.1f, 0.45f, 0.3f}, {0.95f, 0.93f, 0.86f}, 'E'},
                              {{0.88f, 0.62f, 0.13f}, {0.35f, 0.12f, 0.12f}, 'S'},
                              {{0.66f, 0.12f, 0.14f}, {0.96f, 0.9f, 0.75f}, 'W'}};

/// Signed distance to the emblem, in banner units (1 wide), around its centre.
float emblem_distance(int which, glm::vec2 p) {
    const float radius = glm::length(p), angle = std::atan2(p.x, -p.y);
    switch (which) {
    case 0: {  // a star
        const float a = std::abs(std::remainder(angle, 2 * pi_f / 5));
        return radius * std::cos(a) + 0.55f * radius * std::sin(a) * 2 - 0.26f;
    }
    case 1: {  // waves
        const float wave = p.y + 0.035f * std::sin(4 * pi_f * p.x);
        return std::max(std::abs(std::remainder(wave, 0.15f)) - 0.03f, radius - 0.27f);
    }
    case 2: {  // a sun
        const float rays = 0.2f + 0.07f * std::max(0.0f, std::cos(12 * angle));
        return std::abs(radius - 0.165f) < 0.012f ? 0.01f : radius - rays;
    }
    default: {  // a tree
        const float crown =
            std::min(glm::length(p - glm::vec2(0, -0.12f)) - 0.15f,
                     std::min(glm::length(p - glm::vec2(-0.13f, 0)), glm::length(p - glm::vec2(0.13f, 0))) - 0.13f);
        return std::min(crown, std::max(std::abs(p.x) - 0.028f, std::abs(p.y - 0.13f) - 0.15f));
    }
    }
}

}  // namespace

ByteImage paint_banner(int which) {
    const Banner& banner = banners[which];
    return paint(512, 1024, 3, [&](glm::vec2 at) {
        constexpr float soft = 0.006f;
        const glm::vec2 p(at.x, 2 * at.y);  // in widths
        glm::vec3 colour = banner.field;
        const float to_edge = std::min({p.x, 1 - p.x, p.y, 2 - p.y});
        colour = glm::mix(colour, banner.charge, coverage(std::abs(to_edge - 0.07f) - 0.016f, soft));
        colour = glm::mix(colour, banner.charge, coverage(emblem_distance(which, p - glm::vec2(0.5f, 0.6f)), soft));
        constexpr float height = 0.46f;
        const glm::vec2 in_letter = (p - glm::vec2(0.5f - 0.5f * letter_width * height, 1.15f)) / height;
        const float line = height * distance_to_text({&banner.letter, 1}, in_letter) - 0.038f;
        colour = glm::mix(colour, banner.charge, coverage(line, soft));
        const float weave = 0.5f + 0.25f * (std::sin(512 * p.x) + std::sin(512 * p.y));
        return glm::vec4(colour * (0.93f + 0.07f * weave), 1);
    });
}

ByteImage paint_sign(std::string_view text, bool arrow_right) {
    return paint(512, 128, 3, [=](glm::vec2 at) {
        constexpr float soft = 0.016f, height = 0.44f;
        const glm::vec2 p(4 * at.x, at.y);
        const float grain = turbulence(glm::vec2(16, 64) * at, 64, 3, 5900);
        glm::vec3 colour = glm::vec3(0.87f, 0.83f, 0.72f) * (1 + 0.05f * grain);
        const float left = arrow_right ? 0.3f : 1.25f;
        const float line = height * distance_to_text(text, (p - glm::vec2(left, 0.28f)) / height) - 0.035f;
        const float tip = arrow_right ? 3.75f : 0.25f, tail = arrow_right ? 2.75f : 0.95f;
        const float barb = arrow_right ? -0.2f : 0.2f;
        const float arrow = std::min({distance_to_segment(p, {tail, 0.5f}, {tip, 0.5f}),
                                      distance_to_segment(p, {tip, 0.5f}, {tip + barb, 0.28f}),
                                      distance_to_segment(p, {tip, 0.5f}, {tip + barb, 0.72f})}) -
                            0.04f;
        const float to_edge = std::min({p.x, 4 - p.x, p.y, 1 - p.y});
        const float ink =
            std::max({coverage(line, soft), coverage(arrow, soft), coverage(std::abs(to_edge - 0.07f) - 0.015f, soft)});
        return glm::vec4(glm::mix(colour, glm::vec3(0.1f, 0.2f, 0.16f), ink), 1);
    });
}

/// Six gores in turn, white caps, and a band so that its spin can be seen.
ByteImage paint_beach_ball() {
    constexpr glm::vec3 gores[] = {{0.86f, 0.16f, 0.14f}, {0.94f, 0.93f, 0.9f}, {0.98f, 0.76f, 0.1f},
                                   {0.12f, 0.36f, 0.7f},  {0.94f, 0.93f, 0.9f}, {0.1f, 0.58f, 0.36f}};
    return paint(768, 384, 3, [&](glm::vec2 at) {
        const int gore = std::min(5, static_cast<int>(6 * at.x));
        const float seam = std::abs(std::remainder(6 * at.x, 1.0f)) / 6;
        glm::vec3 colour = glm::mix(gores[gore], glm::vec3(0.2f), 0.6f * coverage(seam - 0.0015f, 0.002f));
        const float cap = std::min(at.y, 1 - at.y);
        colour = glm::mix(colour, glm::vec3(0.93f), coverage(cap - 0.08f, 0.006f));
        return glm::vec4(colour, 1);
    });
}

}  // namespace equistream::generate::pavilion
