#include "breakers.h"

#include <string>
#include <utility>

namespace equistream::generate {
namespace {

constexpr glm::dvec3 sky_radiance{0.35, 0.5, 0.8};
constexpr float horizon_m = 300;
constexpr glm::dquat straight_on{1, 0, 0, 0};

/// A painted ground that ends where the sky begins, so far out that it takes it for the horizon.
void add_ground(SceneBuilder& scene, float below_m) {
    scene.object("ground",
                 {scene.mesh("ground", ring(0, horizon_m, 96), painted(scene, "ground", 21, {0.5f, 0.45f, 0.3f}))},
                 moved({0, -below_m, 0}));
}

GeneratedScene under_the_sky(SceneBuilder& scene) {
    GeneratedScene result = finished(scene, {straight_on});
    result.description.sky_radiance = sky_radiance;
    return result;
}

}  // namespace

GeneratedScene make_grazing(const GeneratorValues& values) {
    const auto height_m = static_cast<float>(values.number("height_m", 0.01, 5));
    SceneBuilder scene;
    add_ground(scene, height_m);
    const auto board = scene.mesh("board", box({0.5f, 1.5f, 0.05f}), painted(scene, "board", 22, {0.7f, 0.3f, 0.2f}));
    // Higher than the eyes, so that they stand before the sky.
    for (const auto& [x_m, z_m] : {std::pair{-0.8f, -3.0f}, {2.0f, -7.0f}, {-7.0f, -25.0f}})
        scene.object("board at " + std::to_string(static_cast<int>(-z_m)) + " m", {board},
                     moved({x_m, 0.75f - height_m, z_m}));
    return under_the_sky(scene);
}

/// The railing grows with its distance, so that an eye sees it as large at any: only how much it moves before the sky
/// differs.
GeneratedScene make_sky(const GeneratorValues& values) {
    const auto distance_m = static_cast<float>(values.number("distance_m", 0.05, 100));
    SceneBuilder scene;
    add_ground(scene, 1.6f);
    const auto iron = painted(scene, "iron", 23, {0.9f, 0.8f, 0.3f});
    const float thick_m = 0.04f * distance_m;
    const auto bar = scene.mesh("bar", box({thick_m, 1.3f * distance_m, thick_m}), iron);
    for (int i = -4; i <= 4; ++i)
        scene.object("bar " + std::to_string(i), {bar},
                     moved(distance_m * glm::vec3(0.2f * static_cast<float>(i), 0.15f, -1)));
    const auto rail = scene.mesh("rail", box({1.8f * distance_m, thick_m, thick_m}), iron);
    for (const float y : {-0.3f, 0.6f})
        scene.object(y < 0 ? "lower rail" : "upper rail", {rail}, moved(distance_m * glm::vec3(0, y, -1.05f)));
    return under_the_sky(scene);
}

}  // namespace equistream::generate
