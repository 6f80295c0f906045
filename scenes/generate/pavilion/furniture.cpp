#include "parts.h"

#include <array>
#include <cmath>

namespace equistream::generate::pavilion {
namespace {

constexpr float table_top = 0.74f;

/// Points of an arc in the XY plane, for handles and spouts.
std::vector<glm::vec3> arc(glm::vec2 centre, glm::vec2 radii, float from_rad, float to_rad) {
    std::vector<glm::vec3> points;
    for (int i = 0; i <= 14; ++i) {
        const float a = glm::mix(from_rad, to_rad, static_cast<float>(i) / 14);
        points.emplace_back(centre.x + radii.x * std::cos(a), centre.y + radii.y * std::sin(a), 0);
    }
    return points;
}

Shape even_tube(const std::vector<glm::vec3>& points, float radius, int sides = 12) {
    return tube(points, std::vector<float>(points.size(), radius), sides);
}

Shape pedestal() {
    Shape shape;
    append(shape, bevelled_box({0.46f, 0.1f, 0.46f}, 0.008f), moved({0, 0.05f, 0}));
    append(shape, bevelled_box({0.4f, 0.05f, 0.4f}, 0.02f), moved({0, 0.125f, 0}));
    append(shape, bevelled_box({0.34f, 0.68f, 0.34f}, 0.006f), moved({0, 0.49f, 0}));
    append(shape, bevelled_box({0.39f, 0.05f, 0.39f}, 0.02f), moved({0, 0.855f, 0}));
    append(shape, bevelled_box({0.46f, 0.07f, 0.46f}, 0.01f), moved({0, 0.915f, 0}));
    return shape;
}
constexpr float pedestal_top = 0.95f;

/// The brass ring a ball of this radius sits in; its centre is then at ball_height above the pedestal.
constexpr float cradle_radius = 0.11f, cradle_wire = 0.018f;
Shape cradle() {
    std::vector<glm::vec3> circle;
    for (int i = 0; i <= 48; ++i) {
        const float a = tau * static_cast<float>(i % 48) / 48;
        circle.emplace_back(cradle_radius * std::cos(a), cradle_wire, cradle_radius * std::sin(a));
    }
    return even_tube(circle, cradle_wire);
}
float ball_height(float radius) {
    const float reach = radius + cradle_wire;
    return cradle_wire + std::sqrt(reach * reach - cradle_radius * cradle_radius);
}

Shape vase() {
    constexpr glm::vec2 outline[] = {
        {0, 0},           {0.1f, 0},        {0.11f, 0.012f},  {0.095f, 0.03f},  {0.06f, 0.05f},   {0.052f, 0.07f},
        {0.07f, 0.095f},  {0.12f, 0.14f},   {0.165f, 0.2f},   {0.19f, 0.27f},   {0.192f, 0.33f},  {0.175f, 0.39f},
        {0.14f, 0.44f},   {0.1f, 0.475f},   {0.075f, 0.505f}, {0.068f, 0.54f},  {0.075f, 0.575f}, {0.1f, 0.61f},
        {0.125f, 0.63f},  {0.128f, 0.636f}, {0.122f, 0.638f}, {0.095f, 0.615f}, {0.068f, 0.575f}, {0.06f, 0.54f},
        {0.068f, 0.505f}, {0.09f, 0.47f},   {0, 0.4f}};
    return lathe(outline, 96);
}

Shape cup() {
    constexpr glm::vec2 outline[] = {{0, 0},
                                     {0.024f, 0},
                                     {0.025f, 0.006f},
                                     {0.031f, 0.012f},
                                     {0.038f, 0.026f},
                                     {0.042f, 0.045f},
                                     {0.0435f, 0.068f},
                                     {0.044f, 0.074f},
                                     {0.0425f, 0.075f},
                                     {0.041f, 0.072f},
                                     {0.0395f, 0.045f},
                                     {0.035f, 0.026f},
                                     {0.027f, 0.014f},
                                     {0.015f, 0.01f},
                                     {0, 0.01f}};
    Shape shape = lathe(outline, 48);
    append(shape, even_tube(arc({0.043f, 0.042f}, {0.024f, 0.02f}, -1.65f, 1.75f), 0.0042f));
    return shape;
}

Shape saucer() {
    constexpr glm::vec2 outline[] = {{0, 0},           {0.035f, 0},      {0.04f, 0.004f},
                                     {0.07f, 0.014f},  {0.072f, 0.016f}, {0.07f, 0.0165f},
                                     {0.04f, 0.0075f}, {0.03f, 0.005f},  {0, 0.005f}};
    return lathe(outline, 48);
}

Shape teapot() {
    std::vector<glm::vec2> outline{{0, 0}, {0.05f, 0}, {0.055f, 0.006f}, {0.052f, 0.012f}};
    for (int i = 0; i <= 16; ++i) {
        const float a = glm::mix(-1.15f, 1.2f, static_cast<float>(i) / 16);
        outline.emplace_back(0.012f + 0.088f * std::cos(a), 0.085f + 0.08f * std::sin(a));
    }
    outline.insert(outline.end(), {{0.046f, 0.163f},
                                   {0.03f, 0.173f},
                                   {0.01f, 0.178f},
                                   {0.008f, 0.184f},
                                   {0.014f, 0.194f},
                                   {0.013f, 0.204f},
                                   {0, 0.208f}});
    Shape shape = lathe(outline, 64);
    append(shape, even_tube(arc({-0.095f, 0.095f}, {0.05f, 0.05f}, 1.25f, 5.1f), 0.0075f));
    std::vector<glm::vec3> spout;
    std::vector<float> radii;
    for (int i = 0; i <= 10; ++i) {
        const float t = static_cast<float>(i) / 10;
        spout.emplace_back(0.085f + 0.075f * t, 0.06f + 0.1f * t * t * (1.6f - 0.6f * t), 0);
        radii.push_back(glm::mix(0.022f, 0.009f, std::sqrt(t)));
    }
    append(shape, tube(spout, radii, 20));
    return shape;
}

/// Four posts between a foot and a hat, a glowing bulb inside, a ring on top.
Shape lantern_frame() {
    constexpr glm::vec2 foot[] = {{0, 0},         {0.085f, 0},     {0.09f, 0.006f}, {0.085f, 0.016f},
                                  {0.03f, 0.02f}, {0.025f, 0.06f}, {0, 0.06f}};
    constexpr glm::vec2 hat[] = {{0, 0.235f},   {0.1f, 0.235f},   {0.1f, 0.243f}, {0.05f, 0.285f},
                                 {0.02f, 0.3f}, {0.014f, 0.318f}, {0, 0.32f}};
    Shape shape = lathe(foot, 48);
    append(shape, lathe(hat, 48));
    const Shape post = lathe(std::array<glm::vec2, 2>{{{0.004f, 0.012f}, {0.004f, 0.237f}}}, 10);
    for (int i = 0; i < 8; ++i) {
        const float a = tau * (static_cast<float>(i) + 0.5f) / 8;
        append(shape, post, moved({0.077f * std::cos(a), 0, 0.077f * std::sin(a)}));
    }
    for (const float height : {0.09f, 0.165f}) {
        std::vector<glm::vec3> hoop;
        for (int i = 0; i <= 32; ++i)
            hoop.emplace_back(0.077f * std::cos(tau * static_cast<float>(i % 32) / 32), height,
                              0.077f * std::sin(tau * static_cast<float>(i % 32) / 32));
        append(shape, even_tube(hoop, 0.003f, 8));
    }
    append(shape, even_tube(arc({0, 0.335f}, {0.022f, 0.022f}, 0, tau), 0.0035f, 8));
    return shape;
}

Shape lamp_bulb() {
    Shape bulb = sphere(0.038f, 16, 8);
    for (glm::vec3& p : bulb.positions)
        p = p * glm::vec3(1, 1.35f, 1) + glm::vec3(0, 0.108f, 0);
    return bulb;
}

void build_stool(Site& site, glm::vec3 at, float turn) {
    Shape shape;
    constexpr glm::vec2 seat[] = {{0, 0.43f},      {0.18f, 0.43f},  {0.19f, 0.44f},
                                  {0.19f, 0.455f}, {0.18f, 0.465f}, {0, 0.465f}};
    append(shape, lathe(seat, 48));
    for (int i = 0; i < 4; ++i) {
        const float a = tau * (static_cast<float>(i) + 0.5f) / 4;
        const glm::vec3 foot(0.2f * std::cos(a), 0, 0.2f * std::sin(a)),
            head(0.13f * std::cos(a), 0.44f, 0.13f * std::sin(a));
        append(shape, tube(std::array{foot, head}, std::array{0.014f, 0.019f}, 16));
        const float b = a + tau / 4;
        const glm::vec3 next(0.2f * std::cos(b), 0, 0.2f * std::sin(b)),
            next_head(0.13f * std::cos(b), 0.44f, 0.13f * std::sin(b));
        append(shape, tube(std::array{glm::mix(foot, head, 0.35f), glm::mix(next, next_head, 0.35f)},
                           std::array{0.009f, 0.009f}, 12));
    }
    site.scene.object("stool", {site.scene.mesh("stool", std::move(shape), site.paint.wood)},
                      moved(at) * turned_y(turn));
}

Shape table_frame() {
    constexpr float length = 1.3f, width = 0.76f;
    Shape shape;
    for (int i = 0; i < 5; ++i)
        append(shape, plank({length, 0.032f, width / 5 - 0.004f}),
               moved({0, table_top - 0.016f, width * ((static_cast<float>(i) + 0.5f) / 5 - 0.5f)}));
    const glm::mat4 upright = glm::rotate(glm::mat4(1), tau / 4, glm::vec3(0, 0, 1));
    for (const float x : {-1.0f, 1.0f})
        for (const float z : {-1.0f, 1.0f})
            append(shape, plank({table_top - 0.032f, 0.06f, 0.06f}),
                   moved({x * (0.5f * length - 0.07f), 0.5f * (table_top - 0.032f), z * (0.5f * width - 0.07f)}) *
                       upright);
    for (const float z : {-1.0f, 1.0f})
        append(shape, plank({length - 0.2f, 0.08f, 0.022f}),
               moved({0, table_top - 0.072f, z * (0.5f * width - 0.07f)}));
    for (const float x : {-1.0f, 1.0f})
        append(shape, plank({width - 0.2f, 0.08f, 0.022f}),
               moved({x * (0.5f * length - 0.07f), table_top - 0.072f, 0}) * turned_y(tau / 4));
    return shape;
}

void lay_table(Site& site, const glm::mat4& on_table) {
    SceneBuilder& scene = site.scene;
    const Paintwork& paint = site.paint;
    const std::uint32_t cup_mesh = scene.mesh("cup", cup(), paint.china);
    const std::uint32_t saucer_mesh = scene.mesh("saucer", saucer(), paint.china);
    const std::uint32_t tea_mesh = scene.mesh("tea", ring(0, 0.0402f, 48), paint.tea);
    const auto place_cup = [&](glm::vec2 at, float turn) {
        const glm::mat4 here = on_table * moved({at.x, 0, at.y}) * turned_y(turn);
        scene.object("saucer", {saucer_mesh}, here);
        scene.object("cup", {cup_mesh}, here * moved({0, 0.0055f, 0}));
        scene.object("tea", {tea_mesh}, here * moved({0, 0.0625f, 0}));
    };
    place_cup({-0.2f, 0.24f}, 0.6f);
    place_cup({0.33f, 0.2f}, 2.4f);
    scene.object("teapot", {scene.mesh("teapot", teapot(), paint.china)},
                 on_table * moved({0.06f, 0, 0.05f}) * turned_y(0.9f));
    constexpr glm::vec2 bowl[] = {{0, 0},           {0.05f, 0},       {0.055f, 0.01f}, {0.1f, 0.04f}, {0.14f, 0.085f},
                                  {0.136f, 0.088f}, {0.096f, 0.046f}, {0.05f, 0.018f}, {0, 0.014f}};
    const glm::mat4 bowl_place = on_table * moved({-0.36f, 0, -0.12f});
    scene.object("bowl", {scene.mesh("bowl", lathe(bowl, 64), paint.copper)}, bowl_place);
    const std::uint32_t fruit = scene.mesh("orange", sphere(0.039f, 24, 12), paint.orange);
    for (int i = 0; i < 5; ++i) {
        const float a = tau * static_cast<float>(i) / 5;
        scene.object("orange", {fruit}, bowl_place * moved({0.067f * std::cos(a), 0.072f, 0.067f * std::sin(a)}));
    }
    scene.object("orange", {fruit}, bowl_place * moved({0, 0.122f, 0}));
    Shape pages;
    append(pages, box({0.148f, 0.024f, 0.206f}), moved({0.002f, 0.016f, 0}));
    Shape cover;
    append(cover, box({0.155f, 0.003f, 0.215f}), moved({0, 0.0015f, 0}));
    append(cover, box({0.155f, 0.003f, 0.215f}), moved({0, 0.0305f, 0}));
    append(cover, box({0.003f, 0.026f, 0.215f}), moved({-0.076f, 0.016f, 0}));
    scene.object(
        "book", {scene.mesh("pages", std::move(pages), paint.china), scene.mesh("cover", std::move(cover), paint.book)},
        on_table * moved({0.05f, 0, -0.23f}) * turned_y(0.35f));
}

}  // namespace

void build_pedestals(Site& site) {
    SceneBuilder& scene = site.scene;
    const std::uint32_t stand = scene.mesh("pedestal", pedestal(), site.paint.limestone);
    const std::uint32_t ring_mesh = scene.mesh("cradle", cradle(), site.paint.brass);
    const auto ball_on_pedestal = [&](const std::string& name, glm::vec3 at, float radius, std::uint32_t material) {
        scene.object("pedestal", {stand}, moved(at));
        scene.object("cradle", {ring_mesh}, moved(at + glm::vec3(0, pedestal_top, 0)));
        scene.object(name, {scene.mesh(name, sphere(radius, 112, 56), material)},
                     moved(at + glm::vec3(0, pedestal_top + ball_height(radius), 0)));
    };
    ball_on_pedestal("glass ball", {glass_ball_centre.x, 0, glass_ball_centre.z}, glass_ball_radius,
                     site.paint.tinted_glass);
    ball_on_pedestal("mirror ball", {0.35f, 0, -3.3f}, 0.3f, site.paint.mirror);
    const glm::vec3 vase_at(1.5f, 0, -0.6f);
    scene.object("pedestal", {stand}, moved(vase_at) * turned_y(0.4f));
    scene.object("vase", {scene.mesh("vase", vase(), site.paint.copper)},
                 moved(vase_at + glm::vec3(0, pedestal_top, 0)));
}

void build_table(Site& site) {
    const glm::mat4 here = moved({-2.85f, 0, -0.45f}) * turned_y(tau / 4 + 0.08f);
    site.scene.object("table", {site.scene.mesh("table", table_frame(), site.paint.wood)}, here);
    lay_table(site, here * moved({0, table_top, 0}));
    build_stool(site, {-2.95f, 0, 0.75f}, 0.3f);
    build_stool(site, {-3.62f, 0, -0.7f}, 1.1f);
}

void build_lanterns(Site& site) {
    SceneBuilder& scene = site.scene;
    const std::uint32_t frame = scene.mesh("lantern", lantern_frame(), site.paint.brass);
    const std::uint32_t bulb = scene.mesh("lamp", lamp_bulb(), site.paint.lamp);
    const auto hang = [&](const std::string& name, glm::mat4 at) {
        scene.object(name, {frame}, at);
        scene.object(name + " bulb", {bulb}, at);
    };
    hang("table lantern", moved({-2.75f, table_top, -0.93f}));
    // Under rafters, on a thin rod from the ring on top.
    for (const float bearing : {37.5f, 322.5f, 142.5f}) {
        const float height = 2.2f, radius = 3.3f, ring_top = 0.357f;
        hang("hanging lantern", moved(at_bearing(bearing, radius, height)));
        const std::uint32_t rod = scene.mesh(
            "lantern rod",
            lathe(std::array<glm::vec2, 2>{{{0.004f, height + ring_top - 0.006f}, {0.004f, rafter_bottom}}}, 10),
            site.paint.iron);
        scene.object("lantern rod", {rod}, moved(at_bearing(bearing, radius, 0)));
    }
}

PosePath ball_path(double duration_s, double frames_per_second) {
    const glm::dvec3 start(3.55, ball_radius, -1.15), end(-3.05, ball_radius, -2.75);
    const glm::dvec3 along = glm::normalize(end - start), axis = glm::cross(glm::dvec3(0, 1, 0), along);
    const double length = glm::length(end - start);
    std::vector<PosePath::Key> keys;
    const int count = static_cast<int>(std::lround(duration_s * frames_per_second)) + 1;
    for (int i = 0; i < count; ++i) {
        const double t = static_cast<double>(i) / (count - 1);
        const double rolled = length * t * (1.75 - 0.75 * t);  // slowing down
        const glm::dquat tilt = glm::angleAxis(0.5, glm::dvec3(1, 0, 0));
        keys.push_back(
            {i / frames_per_second, {start + rolled * along, glm::angleAxis(rolled / ball_radius, axis) * tilt}});
    }
    return PosePath(std::move(keys), "ball");
}

}  // namespace equistream::generate::pavilion
