#include "paintwork.h"

#include <scenes/generate/paint.h>

#include <algorithm>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

/// One leaf of a twig: where its stalk is, which way it points, how long and wide (texture units).
struct Leaf {
    glm::vec2 base, direction;
    float length, width, shade;
};

/// Along the leaf in x (0 stalk, 1 tip) and across in y, in lengths.
glm::vec2 leaf_coordinates(const Leaf& leaf, glm::vec2 p) {
    const glm::vec2 d = p - leaf.base;
    return glm::vec2(glm::dot(d, leaf.direction), d.x * leaf.direction.y - d.y * leaf.direction.x) / leaf.length;
}

float leaf_distance(const Leaf& leaf, glm::vec2 q) {
    const float s = glm::clamp(q.x, 0.0f, 1.0f);
    const float half = 0.5f * leaf.width * std::sin(pi_f * std::pow(s, 0.75f));
    return leaf.length * std::max(std::abs(q.y) - half, std::max(-q.x, q.x - 1));
}

glm::vec3 leaf_colour(const Leaf& leaf, glm::vec2 q, glm::vec3 green) {
    const float rib = coverage(std::abs(q.y) - 0.012f, 0.02f);
    const float vein = coverage(std::abs(std::remainder(q.x - 0.9f * std::abs(q.y), 0.14f)) - 0.006f, 0.02f);
    const float mottle = noise(18.0f * q, 1024, 77);
    return green * leaf.shade * (1 + 0.06f * mottle) * (1 + 0.35f * rib + 0.13f * vein);
}

std::vector<Leaf> twig_leaves() {
    Random random(21);
    std::vector<Leaf> leaves;
    for (int i = 0; i < 11; ++i) {
        const float t = static_cast<float>(i) / 10;
        const float side = i % 2 ? 1.0f : -1.0f;
        const float angle = i == 10 ? 0 : side * random.between(0.6f, 1.05f);
        leaves.push_back({{0.5f + 0.02f * std::sin(5 * t), 0.97f - 0.62f * t},
                          {std::sin(angle), -std::cos(angle)},
                          random.between(0.3f, 0.4f) * (1 - 0.2f * t),
                          random.between(0.4f, 0.5f),
                          random.between(0.8f, 1.2f)});
    }
    return leaves;
}

}  // namespace

ByteImage paint_twig() {
    const std::vector<Leaf> leaves = twig_leaves();
    const glm::vec3 green(0.33f, 0.48f, 0.15f);
    return paint(512, 512, 4, [&](glm::vec2 at) {
        const float stem = distance_to_segment(at, {0.5f, 1}, {0.51f, 0.38f}) - 0.007f;
        glm::vec4 result(green, coverage(stem, 0.004f));
        if (result.a > 0)
            result = glm::vec4(0.4f, 0.32f, 0.17f, result.a);
        for (const Leaf& leaf : leaves) {
            const glm::vec2 q = leaf_coordinates(leaf, at);
            const float cover = coverage(leaf_distance(leaf, q), 0.004f);
            if (cover > 0)
                result = glm::vec4(leaf_colour(leaf, q, green), std::max(cover, result.a));
        }
        return result;
    });
}

/// Five lobes about the stalk at the bottom middle.
ByteImage paint_ivy_leaf() {
    return paint(256, 256, 4, [](glm::vec2 at) {
        const glm::vec2 p = at - glm::vec2(0.5f, 0.62f);
        const float radius = glm::length(p), angle = std::atan2(p.x, -p.y);
        const float lobes = 0.5f + 0.5f * std::cos(5 * angle);
        const float notch = glm::smoothstep(2.5f, 3.1f, std::abs(angle));
        const float reach = (0.27f + 0.13f * lobes + 0.1f * std::cos(angle)) * (1 - 0.75f * notch);
        const float stalk = distance_to_segment(at, {0.5f, 0.62f}, {0.5f, 1}) - 0.012f;
        float vein = 1;
        for (int i = -2; i <= 2; ++i) {
            const float a = 1.2566f * static_cast<float>(i);
            vein = std::min(vein, distance_to_segment(p, {0, 0}, 0.36f * glm::vec2(std::sin(a), -std::cos(a))));
        }
        const float mottle = turbulence(8.0f * at, 8, 3, 78);
        const glm::vec3 green = glm::vec3(0.2f, 0.36f, 0.13f) * (1 + 0.15f * mottle);
        const glm::vec3 colour =
            glm::mix(green, glm::vec3(0.55f, 0.64f, 0.35f), 0.75f * coverage(vein - 0.006f, 0.014f));
        return glm::vec4(colour, coverage(std::min(radius - reach, stalk), 0.006f));
    });
}

/// A long leaf that stands from the bottom edge to the top, with a pale rib and torn edges.
ByteImage paint_long_leaf() {
    return paint(256, 1024, 4, [](glm::vec2 at) {
        const float along = 1 - at.y, across = std::abs(at.x - 0.5f);
        const float outline = 0.47f * std::pow(std::sin(pi_f * std::pow(glm::clamp(along, 0.0f, 1.0f), 0.62f)), 0.75f);
        const float slit = std::abs(std::remainder(along - 0.35f * across, 0.09f));
        const bool torn =
            across > 0.2f && slit < 0.0025f + 0.004f * (noise({40 * along, at.x > 0.5f ? 3.5f : 8.5f}, 64, 79));
        const float edge = std::max(std::min(across - outline, 1.0f), across - 0.47f);
        const float stalk = across - 0.035f;
        const float veins = coverage(std::abs(std::remainder(along - 0.35f * across, 0.0225f)) - 0.001f, 0.006f);
        const float mottle = turbulence(glm::vec2(3, 12) * at, {3, 12}, 3, 80);
        glm::vec3 colour = glm::vec3(0.27f, 0.47f, 0.17f) * (1 + 0.12f * mottle + 0.1f * veins);
        colour = glm::mix(colour, glm::vec3(0.62f, 0.71f, 0.36f), coverage(across - 0.022f, 0.02f));
        const float cover = torn ? 0 : coverage(edge, 0.02f);
        return glm::vec4(colour, along < 0.12f ? std::max(cover, coverage(stalk, 0.01f)) : cover);
    });
}

/// Scale-like sprays rising from the bottom edge.
ByteImage paint_cypress() {
    return paint(256, 256, 4, [](glm::vec2 at) {
        const glm::vec3 green(0.17f, 0.27f, 0.13f);
        float nearest = 1;
        Random random(33);
        for (int i = 0; i < 26; ++i) {
            const glm::vec2 base(random.between(0.3f, 0.7f), random.between(0.45f, 1.0f));
            const glm::vec2 tip = base + glm::vec2(random.between(-0.22f, 0.22f), -random.between(0.25f, 0.42f));
            nearest = std::min(nearest, distance_to_segment(at, base, tip));
        }
        const float shade = 1 + 0.35f * noise(24.0f * at, 24, 81);
        return glm::vec4(green * shade, coverage(nearest - 0.022f, 0.008f));
    });
}

ByteImage paint_lawn() {
    return paint(1024, 1024, 3, [](glm::vec2 at) {
        const float tufts = turbulence(64.0f * at, 64, 3, 6000), patches = turbulence(6.0f * at, 6, 5, 6100);
        const float blades = turbulence(glm::vec2(256, 128) * at, {256, 128}, 2, 6200);
        const float clover = glm::smoothstep(0.25f, 0.5f, turbulence(9.0f * at, 9, 4, 6250));
        const glm::vec3 fresh(0.3f, 0.43f, 0.14f), dry(0.5f, 0.48f, 0.23f), dark(0.19f, 0.33f, 0.13f);
        glm::vec3 colour = glm::mix(fresh, dry, glm::clamp(0.3f + 0.6f * patches + 0.15f * tufts, 0.0f, 1.0f));
        colour = glm::mix(colour, dark, 0.7f * clover);
        return glm::vec4(colour * (1 + 0.25f * tufts + 0.2f * blades), 1);
    });
}

/// x round the horizon, y from the lawn's rim (0) to the horizon (1): meadows, fields behind hedges, woods, and more
/// air before them the farther they are.
ByteImage paint_far_land() {
    return paint(2048, 512, 3, [](glm::vec2 at) {
        const float woods = glm::smoothstep(0.1f, 0.2f, turbulence(glm::vec2(36, 9) * at, {36, 9}, 4, 6300));
        const float leaves = turbulence(glm::vec2(512, 160) * at, {512, 160}, 2, 6400);
        // Fields: cells of a warped grid, each with its own crop.
        const glm::vec2 warp(noise(glm::vec2(20, 9) * at, {20, 9}, 6500), noise(glm::vec2(20, 9) * at, {20, 9}, 6600));
        const glm::vec2 warped = glm::vec2(32, 8) * at + 0.4f * warp;
        const glm::vec2 cell = glm::floor(warped);
        const int column = (static_cast<int>(cell.x) + 32) % 32;
        Random crop(static_cast<std::uint64_t>(column + 64 * static_cast<int>(cell.y + 2) + 7777));
        const glm::vec3 field = glm::mix(glm::vec3(0.34f, 0.45f, 0.16f), glm::vec3(0.8f, 0.7f, 0.38f), crop.uniform());
        const glm::vec2 to_edge = 0.5f - glm::abs(warped - cell - 0.5f);
        const glm::vec3 trees = glm::vec3(0.17f, 0.27f, 0.12f) * (1 + 0.35f * leaves);
        glm::vec3 colour = field * (1 + 0.07f * leaves);
        colour = glm::mix(colour, trees, coverage(std::min(to_edge.x, to_edge.y) - 0.035f * (1 + leaves), 0.03f));
        colour = glm::mix(colour, trees, woods);
        colour = glm::mix(lawn_colour * (1 + 0.08f * leaves), colour, glm::smoothstep(0.02f, 0.14f, at.y));
        const float air = 0.8f * std::pow(glm::smoothstep(0.3f, 1.0f, at.y), 1.5f);
        return glm::vec4(glm::mix(colour, glm::vec3(0.55f, 0.64f, 0.76f), air), 1);
    });
}

ByteImage paint_bark() {
    return paint(256, 512, 3, [](glm::vec2 at) {
        const float ridges = std::abs(turbulence(glm::vec2(12, 5) * at, {12, 5}, 5, 6700));
        const float fine = turbulence(glm::vec2(48, 24) * at, {48, 24}, 3, 6800);
        return glm::vec4(glm::vec3(0.42f, 0.34f, 0.26f) * (0.55f + 0.8f * ridges + 0.15f * fine), 1);
    });
}

}  // namespace equistream::generate::pavilion
