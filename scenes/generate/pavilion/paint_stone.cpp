#include "paintwork.h"

#include <scenes/generate/paint.h>

#include <algorithm>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

/// Dark lines where warped noise crosses zero; `period` cells a texture.
float veins(glm::vec2 at, int period, float sharpness, std::uint32_t seed) {
    const glm::vec2 p = at * static_cast<float>(period);
    const glm::vec2 warp(turbulence(p, period, 4, seed + 50), turbulence(p, period, 4, seed + 70));
    return std::pow(1 - std::min(1.0f, std::abs(turbulence(p + 0.8f * warp, period, 5, seed))), sharpness);
}

/// A piece of marble: ground colour, clouds and two sets of veins.
glm::vec3 marble(glm::vec2 at, glm::vec3 ground, glm::vec3 vein, std::uint32_t seed) {
    const float cloud = 0.5f + 0.5f * turbulence(4.0f * at, 4, 5, seed + 3);
    const float strong = veins(at, 3, 22, seed), fine = veins(at, 7, 16, seed + 200);
    return glm::mix(ground * (0.9f + 0.14f * cloud), vein, std::min(0.85f, 0.75f * strong + 0.35f * fine * cloud));
}

glm::vec3 white_marble(glm::vec2 at, std::uint32_t seed) {
    return marble(at, {0.88f, 0.865f, 0.83f}, {0.5f, 0.5f, 0.53f}, seed);
}

glm::vec3 charcoal_marble(glm::vec2 at, std::uint32_t seed) {
    return marble(at, {0.25f, 0.27f, 0.29f}, {0.72f, 0.7f, 0.66f}, seed);
}

glm::vec3 green_marble(glm::vec2 at, std::uint32_t seed) {
    return marble(at, {0.15f, 0.29f, 0.24f}, {0.55f, 0.66f, 0.58f}, seed);
}

glm::vec3 ochre_marble(glm::vec2 at, std::uint32_t seed) {
    return marble(at, {0.76f, 0.58f, 0.33f}, {0.5f, 0.28f, 0.16f}, seed);
}

glm::vec3 red_marble(glm::vec2 at, std::uint32_t seed) {
    return marble(at, {0.56f, 0.25f, 0.2f}, {0.86f, 0.76f, 0.68f}, seed);
}

}  // namespace

/// Four by four square tiles, white and charcoal by turns, two of the dark ones red; each cut from its own block.
ByteImage paint_tiles() {
    return paint(1024, 1024, 3, [](glm::vec2 at) {
        const glm::vec2 p = 4.0f * at;
        const int i = static_cast<int>(p.x), j = static_cast<int>(p.y);
        const auto seed = static_cast<std::uint32_t>(1000 + 40 * (4 * j + i));
        // A block is twice a tile wide, so that veins are as long as tiles.
        const glm::vec2 in_block = 0.5f * (p - glm::floor(p)) + 0.1f * glm::vec2(i, j);
        const bool red = (i == 1 && j == 0) || (i == 3 && j == 2);
        const glm::vec3 stone = (i + j) % 2 == 0 ? white_marble(in_block, seed)
                                : red            ? red_marble(in_block, seed)
                                                 : charcoal_marble(in_block, seed);
        const glm::vec2 to_edge = 0.5f - glm::abs(p - glm::floor(p) - 0.5f);
        const float joint = coverage(std::min(to_edge.x, to_edge.y) - 0.007f, 0.006f);
        return glm::vec4(glm::mix(stone, glm::vec3(0.42f, 0.4f, 0.37f), joint), 1);
    });
}

namespace {

using Stone = glm::vec3 (*)(glm::vec2, std::uint32_t);

/// Lays a piece of stone in; costs nothing where it does not show.
void inlay(glm::vec3& colour, Stone stone, glm::vec2 at, float cover, std::uint32_t seed) {
    if (cover > 0)
        colour = glm::mix(colour, stone(at, seed), cover);
}

/// Four points, each of a light and a dark half rhomb.
struct Star {
    float reach, waist, turn_rad;
    Stone light, dark;
};

void inlay_star(glm::vec3& colour, const Star& star, glm::vec2 at, glm::vec2 p) {
    const float from_point = std::remainder(std::atan2(p.x, -p.y) - star.turn_rad, 0.5f * pi_f);
    const float a = std::abs(from_point);
    const glm::vec2 q = glm::length(p) * glm::vec2(std::sin(a), std::cos(a));
    const glm::vec2 corner = star.waist * glm::vec2(std::sin(pi_f / 4), std::cos(pi_f / 4));
    const glm::vec2 edge = glm::vec2(0, star.reach) - corner;
    const glm::vec2 normal = glm::normalize(glm::vec2(edge.y, -edge.x));
    inlay(colour, from_point < 0 ? star.dark : star.light, at, coverage(glm::dot(q - corner, normal), 0.003f), 4300);
}

}  // namespace

/// An eight-pointed compass rose with its letters, north at the top.
ByteImage paint_medallion() {
    return paint(1024, 1024, 3, [](glm::vec2 at) {
        constexpr float soft = 0.003f;
        const glm::vec2 p = 2.0f * at - 1.0f;
        const float radius = glm::length(p);
        glm::vec3 colour = white_marble(at, 4000);
        inlay_star(colour, {0.6f, 0.2f, pi_f / 4, ochre_marble, red_marble}, at, p);
        inlay_star(colour, {0.74f, 0.22f, 0, green_marble, charcoal_marble}, at, p);
        inlay(colour, ochre_marble, at, coverage(radius - 0.1f, soft), 4700);
        const float rim = std::min(std::abs(radius - 0.97f) - 0.03f, std::abs(radius - 0.75f) - 0.006f);
        inlay(colour, green_marble, at, coverage(rim, soft), 4800);
        constexpr std::string_view names = "NESW";
        for (int i = 0; i < 4; ++i) {
            const float turn = 0.5f * pi_f * static_cast<float>(i);
            const glm::vec2 upright(std::cos(turn) * p.x + std::sin(turn) * p.y,
                                    -std::sin(turn) * p.x + std::cos(turn) * p.y);
            constexpr float height = 0.14f;
            const glm::vec2 in_letter = (upright - glm::vec2(-0.5f * letter_width * height, -0.925f)) / height;
            const float line = height * distance_to_text(names.substr(i, 1), in_letter) - 0.014f;
            inlay(colour, charcoal_marble, at, coverage(line, soft), 4900);
        }
        return glm::vec4(colour, 1);
    });
}

ByteImage paint_dark_marble() {
    return paint(512, 512, 3, [](glm::vec2 at) { return glm::vec4(green_marble(at, 5000), 1); });
}

/// Warm stone with faint beds and pits.
ByteImage paint_limestone() {
    return paint(512, 512, 3, [](glm::vec2 at) {
        const float stain = turbulence(3.0f * at, 3, 5, 5100);
        const float beds = turbulence(glm::vec2(2, 16) * at, {2, 16}, 3, 5200);
        const float pits = std::max(0.0f, turbulence(48.0f * at, 48, 2, 5300) - 0.45f);
        const glm::vec3 colour = glm::vec3(0.85f, 0.8f, 0.71f) * (1 + 0.06f * stain + 0.035f * beds - 0.5f * pits);
        return glm::vec4(glm::mix(colour, glm::vec3(0.72f, 0.62f, 0.47f), 0.25f * std::max(0.0f, stain)), 1);
    });
}

/// Flags of grey stone with worn, mossy edges; one flag.
ByteImage paint_paving() {
    return paint(512, 512, 3, [](glm::vec2 at) {
        const float grain = turbulence(24.0f * at, 24, 4, 5400), patches = turbulence(3.0f * at, 3, 4, 5500);
        const glm::vec3 colour = glm::vec3(0.6f, 0.57f, 0.52f) * (1 + 0.1f * grain + 0.12f * patches);
        const float moss = glm::smoothstep(0.25f, 0.7f, patches + 0.3f * grain);
        return glm::vec4(glm::mix(colour, glm::vec3(0.4f, 0.43f, 0.25f), 0.5f * moss), 1);
    });
}

/// Grain along x: growth rings cut lengthwise, pores, four planks across.
ByteImage paint_wood() {
    return paint(1024, 512, 3, [](glm::vec2 at) {
        const float bend = turbulence(glm::vec2(2, 4) * at, {2, 4}, 3, 5600);
        const float rings = 0.5f + 0.5f * std::sin(2 * pi_f * (9 * at.y + 1.1f * bend));
        const float fibres = turbulence(glm::vec2(8, 96) * at, {8, 96}, 3, 5700);
        const float pores = std::max(0.0f, turbulence(glm::vec2(24, 160) * at, {24, 160}, 2, 5800) - 0.35f);
        const glm::vec3 light(0.72f, 0.5f, 0.3f), dark(0.47f, 0.28f, 0.15f);
        return glm::vec4(glm::mix(light, dark, 0.55f * rings * rings + 0.1f) * (1 + 0.13f * fibres - 0.55f * pores), 1);
    });
}

}  // namespace equistream::generate::pavilion
