#include "bundled.h"
#include "glowing_room.h"
#include "noise.h"

#include <algorithm>
#include <cmath>

namespace equistream::generate {
namespace {

constexpr int keys_a_second = 30;

/// Smooth in every direction, so that sampling between pixels is accurate; no two places alike.
ByteImage clouds(std::uint32_t seed, glm::vec3 tint) {
    return paint(512, 512, 3, [&](glm::vec2 at) {
        glm::vec3 colour;
        for (int c = 0; c < 3; ++c)
            colour[c] = 0.5f + 0.35f * turbulence(8.0f * at, 8, 3, seed + 10 * static_cast<std::uint32_t>(c));
        return glm::vec4(glm::mix(tint, colour, 0.7f), 1);
    });
}

/// From `from` to `to` in one second, turning about `axis`, and back in the next, as long as told.
class Glide {
public:
    explicit Glide(int seconds) : seconds_(seconds) {}

    PosePath operator()(glm::dvec3 from, glm::dvec3 to, glm::dvec3 axis, double turn_rad) const {
        std::vector<PosePath::Key> keys;
        for (int i = 0; i <= keys_a_second * seconds_; ++i) {
            const int on = i % (2 * keys_a_second), step = std::min(on, 2 * keys_a_second - on);
            const double t = static_cast<double>(step) / keys_a_second;
            keys.push_back({i / static_cast<double>(keys_a_second),
                            {glm::mix(from, to, t), glm::angleAxis(turn_rad * t, glm::normalize(axis))}});
        }
        return PosePath(std::move(keys), "motion");
    }

private:
    int seconds_;
};

std::uint32_t cloudy(SceneBuilder& scene, const std::string& name, std::uint32_t seed, glm::vec3 tint) {
    return scene.material(glowing(name, glm::vec3(1), scene.texture(name, clouds(seed, tint), Encoding::png)));
}

}  // namespace

/// Light only, so frames are free of noise and shading. The ball crosses the seam (straight behind), the block passes
/// over the upper pole.
GeneratedScene make_motion(const GeneratorValues& values) {
    const Glide glide(values.count("seconds", 1, 600));
    SceneBuilder scene;
    add_glowing_room(scene, {6, 5, 6}, [](Side side) {
        return clouds(1000 + 100 * static_cast<std::uint32_t>(side),
                      {side % 2 ? 0.8f : 0.2f, side % 3 ? 0.3f : 0.7f, side < 3 ? 0.6f : 0.3f});
    });
    const auto ball = scene.mesh("ball", sphere(0.35f, 96, 48), cloudy(scene, "ball", 31, {0.9f, 0.2f, 0.1f}));
    const auto block =
        scene.mesh("block", bevelled_box({0.9f, 0.3f, 0.6f}, 0.03f), cloudy(scene, "block", 57, {0.1f, 0.8f, 0.3f}));
    const PosePath ball_path = glide({0.8, -0.2, 1.9}, {-0.8, 0.1, 1.7}, {0, 0, 1}, 1.2);
    const PosePath block_path = glide({-0.5, 1.6, 0.3}, {0.5, 1.7, -0.2}, {0.2, 1, 0}, 0.8);
    scene.object("ball", {ball}, moved(glm::vec3(ball_path.at(0).position_m)));
    scene.object("block", {block}, moved(glm::vec3(block_path.at(0).position_m)));
    GeneratedScene result;
    result.model = scene.finish();
    result.description.camera_path = glide({-0.3, 0, 0.2}, {0.4, 0.15, -0.3}, {0.1, 1, 0}, -0.6);
    result.description.moving = {{"ball", ball_path}, {"block", block_path}};
    return result;
}

}  // namespace equistream::generate
