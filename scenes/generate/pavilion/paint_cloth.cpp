#include "paintwork.h"

#include <scenes/generate/noise.h>

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

constexpr float pi_f = 3.14159265f;

struct Banner {
    glm::vec3 field, charge;
    char letter;
};
constexpr std::array<Banner, 4> banners{{{{0.13f, 0.25f, 0.55f}, {0.95f, 0.85f, 0.5f}, 'N'},
                                         {{0.1f, 0.45f, 0.3f}, {0.95f, 0.93f, 0.86f}, 'E'},
                                         {{0.88f, 0.62f, 0.13f}, {0.35f, 0.12f, 0.12f}, 'S'},
                                         {{0.66f, 0.12f, 0.14f}, {0.96f, 0.9f, 0.75f}, 'W'}}};

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
    constexpr std::array<glm::vec3, 6> gores{{{0.86f, 0.16f, 0.14f},
                                              {0.94f, 0.93f, 0.9f},
                                              {0.98f, 0.76f, 0.1f},
                                              {0.12f, 0.36f, 0.7f},
                                              {0.94f, 0.93f, 0.9f},
                                              {0.1f, 0.58f, 0.36f}}};
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
