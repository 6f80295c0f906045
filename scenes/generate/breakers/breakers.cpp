#include "breakers.h"

#include <scenes/generate/paint.h>
#include <scenes/generate/scene_builder.h>

#include <cmath>

namespace equistream::generate {
namespace {

constexpr double radians = 0.017453292519943295;
const glm::dquat straight_on{1, 0, 0, 0};

/// A pointed oval, upright, bent a little so that its depth is not constant.
Shape leaf_shape(float width_m, float height_m) {
    return sheet(16, 24, [=](float u, float v) {
        const float half = 0.5f * width_m * std::sin(3.1415926f * std::clamp(v, 0.01f, 0.99f));
        const float x = (2 * u - 1) * half;
        return glm::vec3(x, (v - 0.5f) * height_m, -4 * x * x / width_m * 0.3f);
    });
}

glm::dquat tilted(double pitch_rad) {
    return glm::angleAxis(pitch_rad, glm::dvec3(1, 0, 0));
}

}  // namespace

GeneratedScene make_leaf(const GeneratorValues& values) {
    const auto distance_m = static_cast<float>(values.number("distance_m", 0.02, 2));
    SceneBuilder scene;
    add_stage(scene);
    const auto green = painted(scene, "leaf", 11, {0.15f, 0.6f, 0.1f});
    scene.at(green).double_sided = true;
    scene.object("leaf", {scene.mesh("leaf", leaf_shape(0.05f, 0.08f), green)},
                 moved(left_eye_m - glm::vec3(0, 0, distance_m)));
    return finished(scene, {straight_on});
}

GeneratedScene make_near(const GeneratorValues& values) {
    const auto distance_m = static_cast<float>(values.number("distance_m", 0.05, 2));
    constexpr float radius_m = 0.08f;
    SceneBuilder scene;
    add_stage(scene);
    add_ball(scene, "ball", {0, 0, -(distance_m + radius_m)}, radius_m);
    return finished(scene, {straight_on});
}

GeneratedScene make_poles(const GeneratorValues& values) {
    const double pitch_rad = values.number("pitch_deg", -90, 90) * radians;
    SceneBuilder scene;
    add_stage(scene);
    add_ball(scene, "lamp", {0.1f, 0.8f, -0.1f}, 0.2f);
    scene.object("stool",
                 {scene.mesh("stool", box({0.35f, 0.5f, 0.35f}), painted(scene, "cloth", 12, {0.6f, 0.2f, 0.4f}))},
                 moved({-0.1f, -1.1f, 0.05f}) * turned_y(0.4f));
    return finished(scene, {tilted(pitch_rad), tilted(-pitch_rad)});
}

GeneratedScene make_seam(const GeneratorValues& values) {
    const double turn_rad = (180 + values.number("offset_deg", -180, 180)) * radians;
    SceneBuilder scene;
    add_stage(scene);
    add_ball(scene, "ball", {0.05f, 0, -0.9f}, 0.2f);
    // The whole room turns with the head: what the eye sees stays, where it lies in the sphere does not.
    GeneratedScene result = finished(scene, {glm::angleAxis(-turn_rad, glm::dvec3(0, 1, 0))});
    const glm::mat4 turn = turned_y(static_cast<float>(-turn_rad));
    for (Instance& instance : result.model.instances)
        instance.world_from_object = turn * instance.world_from_object;
    for (Object& object : result.model.objects)
        object.world_from_object = turn * object.world_from_object;
    return result;
}

GeneratedScene make_wires(const GeneratorValues& values) {
    constexpr float distance_m = 1.0f;
    const auto width_m = static_cast<float>(values.number("width_px", 0.05, 64) / values.number("focal_px", 1, 1e5) *
                                            static_cast<double>(distance_m));
    SceneBuilder scene;
    add_stage(scene);
    const auto iron = painted(scene, "iron", 13, {0.9f, 0.9f, 0.3f});
    const auto bar = scene.mesh("bar", box({width_m, 1.2f, width_m}), iron);
    for (int i = 0; i < 11; ++i)
        scene.object("bar " + std::to_string(i), {bar}, moved({0.15f * static_cast<float>(i - 5), 0, -distance_m}));
    const auto rail = scene.mesh("rail", box({1.65f, width_m, width_m}), iron);
    for (const float y : {-0.45f, 0.2f, 0.45f})
        scene.object(y < 0 ? "lower rail" : "upper rail", {rail}, moved({0, y, -distance_m - width_m}));
    return finished(scene, {straight_on});
}

/// The mirror stands at 45 degrees and shows what is to its right, so that nothing reflected comes between it and the
/// eyes.
GeneratedScene make_mirror(const GeneratorValues& values) {
    const auto behind_m = static_cast<float>(values.number("behind_m", 0.5, 2.9));
    SceneBuilder scene;
    add_stage(scene);
    const auto mirror = scene.material(metal("mirror", glm::vec3(1), 0));
    scene.at(mirror).double_sided = true;
    scene.object("mirror", {scene.mesh("mirror", card(1.0f, 1.0f), mirror)},
                 moved({0, 0, -1.4f}) * turned_y(0.78539816f));
    const auto poster = painted(scene, "poster", 14, {0.2f, 0.4f, 0.8f});
    scene.at(poster).double_sided = true;
    scene.object("poster", {scene.mesh("poster", card(1.8f, 1.8f), poster)},
                 moved({behind_m, 0, -1.4f}) * turned_y(-1.5707963f));
    return finished(scene, {straight_on});
}

GeneratedScene make_glass(const GeneratorValues& values) {
    const auto behind_m = static_cast<float>(values.number("behind_m", 0.01, 2));
    SceneBuilder scene;
    add_stage(scene);
    scene.object("pane", {scene.mesh("pane", card(0.9f, 0.9f), scene.material(glass("pane")))}, moved({0, 0, -0.8f}));
    const auto poster = painted(scene, "poster", 14, {0.2f, 0.4f, 0.8f});
    scene.object("poster", {scene.mesh("poster", card(2.6f, 2.6f), poster)}, moved({0, 0, -0.8f - behind_m}));
    return finished(scene, {straight_on});
}

/// To the right of `depth_m` before the head's centre all is inside a block: one eye, then both.
GeneratedScene make_inside(const GeneratorValues& values) {
    const auto depth_m = static_cast<float>(values.number("depth_m", -0.5, 0.5));
    constexpr float side_m = 1.2f;
    SceneBuilder scene;
    add_stage(scene);
    const auto block = painted(scene, "block", 15, {0.3f, 0.7f, 0.6f});
    scene.at(block).double_sided = true;
    scene.object("block", {scene.mesh("block", box(glm::vec3(side_m)), block)},
                 moved({0.5f * side_m - depth_m, 0.1f, -0.2f}));
    return finished(scene, {straight_on});
}

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
