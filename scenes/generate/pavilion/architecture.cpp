#include "parts.h"

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

void scale_uv(Shape& shape, float factor) {
    for (glm::vec2& uv : shape.uvs)
        uv *= factor;
}

/// Shaft with twenty flutes that fade out at both ends, and a slight swelling.
Shape fluted_shaft(float bottom, float top) {
    constexpr int flutes = 20, steps = 6, rows = 11;
    return sheet(
        flutes * steps, rows,
        [&](float u, float v) {
            const float radius = 0.24f - 0.045f * v * v - 0.004f * v;
            const float in_flute = u * flutes - std::floor(u * flutes) - 0.5f;
            const float ends = glm::smoothstep(0.0f, 0.05f, v) * glm::smoothstep(0.0f, 0.05f, 1 - v);
            const float cut = std::sqrt(std::max(0.0f, 1 - 5.2f * in_flute * in_flute));
            const float r = radius - 0.02f * ends * cut;
            return glm::vec3(r * std::sin(tau * u), glm::mix(bottom, top, v), r * std::cos(tau * u));
        },
        {1.5f, 2.7f}, true);
}

/// Quarter and half rounds are what mouldings are made of.
void add_round(std::vector<glm::vec2>& outline, glm::vec2 centre, float radius, float from_rad, float to_rad) {
    for (int i = 0; i <= 6; ++i) {
        const float a = glm::mix(from_rad, to_rad, static_cast<float>(i) / 6);
        outline.push_back(centre + radius * glm::vec2(std::cos(a), std::sin(a)));
    }
}

Shape column() {
    Shape shape;
    append(shape, bevelled_box({0.64f, 0.12f, 0.64f}, 0.008f), moved({0, 0.06f, 0}));
    std::vector<glm::vec2> base{{0.27f, 0.12f}};
    add_round(base, {0.27f, 0.165f}, 0.045f, -tau / 4, tau / 4);
    base.insert(base.end(), {{0.268f, 0.21f}, {0.252f, 0.225f}, {0.25f, 0.245f}, {0.262f, 0.26f}});
    add_round(base, {0.255f, 0.29f}, 0.028f, -tau / 4, tau / 4);
    base.insert(base.end(), {{0.245f, 0.318f}, {0.24f, 0.34f}});
    append(shape, lathe(base, 40));
    append(shape, fluted_shaft(0.34f, 3.02f));
    std::vector<glm::vec2> capital{{0.19f, 3.02f}};
    add_round(capital, {0.195f, 3.035f}, 0.018f, -tau / 4, tau / 4);
    capital.insert(capital.end(), {{0.192f, 3.056f}, {0.192f, 3.11f}});
    add_round(capital, {0.19f, 3.19f}, 0.085f, -tau / 4, 0);
    capital.insert(capital.end(), {{0.27f, 3.205f}, {0.2f, 3.205f}});
    append(shape, lathe(capital, 40));
    append(shape, bevelled_box({0.6f, 0.095f, 0.6f}, 0.01f), moved({0, 3.2525f, 0}));
    return shape;
}

Shape entablature() {
    constexpr glm::vec2 outline[] = {{4.17f, 3.3f},  {4.63f, 3.3f},  {4.63f, 3.42f}, {4.65f, 3.42f}, {4.65f, 3.56f},
                                     {4.69f, 3.59f}, {4.69f, 3.62f}, {4.62f, 3.62f}, {4.62f, 3.86f}, {4.66f, 3.89f},
                                     {4.66f, 3.97f}, {4.86f, 3.97f}, {4.86f, 4.05f}, {4.93f, 4.12f}, {4.93f, 4.15f},
                                     {4.17f, 4.15f}, {4.17f, 3.3f}};
    Shape shape = lathe(outline, 192);
    const Shape dentil = box({0.075f, 0.075f, 0.1f});
    for (int i = 0; i < 144; ++i)
        append(shape, dentil, placed(2.5f * static_cast<float>(i), 4.7f, 3.9325f));
    scale_uv(shape, 0.7f);
    return shape;
}

void build_rafters(Site& site) {
    const std::uint32_t rafter = site.scene.mesh("rafter", plank({4.12f, 0.17f, 0.09f}), site.paint.wood);
    for (int i = 0; i < 24; ++i)
        site.scene.object("rafter", {rafter},
                          placed(15.0f * static_cast<float>(i) + 7.5f, 3.09f, rafter_bottom + 0.085f) *
                              turned_y(tau / 4));
    // Rings of battens, from rafter to rafter.
    for (const float radius : {1.75f, 2.6f, 3.45f}) {
        const float length = 2 * (radius + 0.03f) * std::tan(tau / 48);
        const std::uint32_t batten = site.scene.mesh("batten", plank({length, 0.05f, 0.06f}), site.paint.wood);
        for (int i = 0; i < 24; ++i)
            site.scene.object("batten", {batten},
                              placed(15.0f * static_cast<float>(i), radius, rafter_bottom + 0.195f));
    }
    constexpr glm::vec2 hub[] = {{0.92f, 4.1f}, {1.03f, 4.1f}, {1.03f, 4.36f}, {0.92f, 4.36f}, {0.92f, 4.1f}};
    site.scene.add("roof ring", lathe(hub, 96), site.paint.wood);
}

/// Where the railing stands: bays left open are the ways in.
constexpr std::array<float, 6> railed_bays{60, 90, 120, 240, 270, 300};

}  // namespace

glm::vec3 at_bearing(float bearing_deg, float radius, float height) {
    const float a = glm::radians(bearing_deg);
    return {radius * std::sin(a), height, -radius * std::cos(a)};
}

glm::mat4 placed(float bearing_deg, float radius, float height) {
    return moved(at_bearing(bearing_deg, radius, height)) * turned_y(-glm::radians(bearing_deg));
}

Shape plank(glm::vec3 size) {
    Shape shape = bevelled_box(size, 0.06f * std::min({size.x, size.y, size.z}));
    for (std::size_t i = 0; i < shape.uvs.size(); ++i) {
        const glm::vec3 p = shape.positions[i], n = glm::abs(shape.normals[i]);
        const bool end = n.x > 0.9f;
        // A texture is two metres of a board along the grain and 0.7 m across.
        shape.uvs[i] = end ? glm::vec2(p.y, p.z) : glm::vec2(p.x / 2, (n.y > n.z ? p.z : p.y + size.z) / 0.7f);
    }
    return shape;
}

void build_floor_and_steps(Site& site) {
    constexpr float medallion = 1.2f, inner = 1.36f, outer = 4.61f;
    Shape centre = ring(0, medallion, 96);
    for (glm::vec2& uv : centre.uvs)
        uv = uv / (2 * medallion) + 0.5f;
    site.scene.add("medallion", std::move(centre), site.paint.medallion);
    site.scene.add("inner border", ring(medallion, inner, 96), site.paint.dark_marble);
    // Tiles grow outwards so that they stay square: equal steps of log radius and angle.
    const float span = std::log(outer / inner);
    const auto tile_point = [&](float u, float v) {
        const float radius = inner * std::exp(span * (1 - v)), angle = tau * u;
        return glm::vec3(radius * std::sin(angle), 0, radius * std::cos(angle));
    };
    site.scene.add("tiles", sheet(144, 28, tile_point, {9, 1.75f}, true), site.paint.tiles);
    site.scene.add("outer border", ring(outer, 4.9f, 192), site.paint.dark_marble);
    constexpr glm::vec2 outline[] = {{6.1f, -0.9f},   {6.1f, -0.31f},  {6.09f, -0.3f}, {5.62f, -0.3f},
                                     {5.62f, -0.16f}, {5.61f, -0.15f}, {5.3f, -0.15f}, {5.26f, -0.15f},
                                     {5.26f, -0.01f}, {5.25f, 0},      {5.1f, 0},      {4.9f, 0}};
    Shape stairs = lathe(outline, 192);
    scale_uv(stairs, 0.7f);
    site.scene.add("steps", std::move(stairs), site.paint.limestone);
}

void build_columns_and_roof(Site& site) {
    const std::uint32_t shape = site.scene.mesh("column", column(), site.paint.limestone);
    for (int i = 0; i < column_count; ++i)
        site.scene.object("column " + std::to_string(i + 1), {shape},
                          placed(30.0f * static_cast<float>(i) + 15, column_ring_radius, 0));
    site.scene.add("entablature", entablature(), site.paint.limestone);
    build_rafters(site);
}

/// Thin round bars with a knop, two rails and a wooden handrail; straight from column to column.
void build_railings(Site& site) {
    constexpr float half = 0.86f, offset = 4.25f;
    constexpr glm::vec2 bar[] = {{0.0065f, 0.08f}, {0.0065f, 0.5f}, {0.012f, 0.512f}, {0.019f, 0.53f},
                                 {0.021f, 0.545f}, {0.019f, 0.56f}, {0.012f, 0.578f}, {0.0065f, 0.59f},
                                 {0.0065f, 0.75f}, {0.0065f, 0.93f}};
    const std::uint32_t bar_mesh = site.scene.mesh("bar", lathe(bar, 10), site.paint.iron);
    Shape rails;
    append(rails, box({2 * half, 0.025f, 0.035f}), moved({0, 0.08f, 0}));
    append(rails, box({2 * half, 0.02f, 0.035f}), moved({0, 0.925f, 0}));
    const std::uint32_t rail_mesh = site.scene.mesh("rails", std::move(rails), site.paint.iron);
    const std::uint32_t hand_mesh = site.scene.mesh("handrail", plank({2 * half, 0.045f, 0.075f}), site.paint.wood);
    for (const float bay : railed_bays) {
        const glm::mat4 here = placed(bay, offset, 0);
        site.scene.object("railing", {rail_mesh}, here);
        site.scene.object("handrail", {hand_mesh}, here * moved({0, 0.957f, 0}));
        for (int i = 0; i < 15; ++i)
            site.scene.object("bar", {bar_mesh},
                              here * moved({half * (2 * (static_cast<float>(i) + 0.5f) / 15 - 1), 0, 0}));
    }
}

/// Cloth on a rod under the architrave, a little blown.
void build_banners(Site& site) {
    constexpr float width = 0.85f, height = 1.7f, top = 3.16f;
    constexpr std::array<float, 4> bays{30, 120, 210, 300};
    const std::uint32_t rod = site.scene.mesh(
        "rod",
        [] {
            Shape shape = lathe(
                std::array<glm::vec2, 6>{
                    {{0, -0.5f}, {0.014f, -0.5f}, {0.014f, -0.47f}, {0.011f, -0.47f}, {0.011f, 0.5f}, {0, 0.5f}}},
                16);
            for (const float side : {-0.35f, 0.35f})
                append(shape, box({0.16f, 0.008f, 0.008f}), moved({0.08f, side, 0}));
            return shape;
        }(),
        site.paint.brass);
    for (int i = 0; i < 4; ++i) {
        const float phase = 1.7f * static_cast<float>(i);
        const auto cloth = [&](float u, float v) {
            const float sway = 0.075f * (1 - v) * std::sin(5 * u + 3 * v + phase) + 0.1f * (1 - v) * (1 - v);
            return glm::vec3((u - 0.5f) * width, (v - 1) * height, sway + 0.012f);
        };
        const glm::mat4 here = placed(bays[static_cast<std::size_t>(i)], 4.22f, top);
        const auto mesh = site.scene.mesh("banner", v_turned(sheet(24, 36, cloth)), site.paint.banners[i]);
        site.scene.object("banner " + std::to_string(i + 1), {mesh}, here);
        const glm::mat4 lying = glm::rotate(glm::mat4(1), tau / 4, glm::vec3(0, 0, 1));
        site.scene.object("banner rod", {rod}, here * moved({0, 0.01f, 0}) * lying);
    }
}

}  // namespace equistream::generate::pavilion
