#include "parts.h"

#include <scenes/generate/bundled.h>

#include <cmath>

namespace equistream::generate {
namespace {

using namespace pavilion;

constexpr double frames_per_second = 30, duration_s = 5;
constexpr double eye_height_m = 1.6;

/// In from the south, past the leaves, the glass ball and the table, round to the right and on towards the lake.
glm::dvec3 walk(double t) {
    const glm::dvec2 a(-1.45, 3.15), b(-1.95, 0.7), c(-1.5, -2.45), d(1.75, -2.15);
    const double s = 1 - t;
    const glm::dvec2 p = s * s * s * a + 3 * s * s * t * b + 3 * s * t * t * c + t * t * t * d;
    return {p.x, eye_height_m, p.y};
}

/// The same at an even pace: `distance` metres along.
class EvenWalk {
public:
    EvenWalk() {
        for (int i = 1; i <= steps; ++i)
            lengths_[i] = lengths_[i - 1] + glm::length(walk(at(i)) - walk(at(i - 1)));
    }
    double length() const { return lengths_[steps]; }
    double parameter(double distance) const {
        int i = 1;
        while (i < steps && lengths_[i] < distance)
            ++i;
        return glm::mix(at(i - 1), at(i), (distance - lengths_[i - 1]) / (lengths_[i] - lengths_[i - 1]));
    }

private:
    static constexpr int steps = 400;
    static double at(int i) { return static_cast<double>(i) / steps; }
    double lengths_[steps + 1] = {};
};

PosePath head_path() {
    const EvenWalk even;
    std::vector<PosePath::Key> keys;
    const int count = static_cast<int>(std::lround(duration_s * frames_per_second));
    for (int i = 0; i < count; ++i) {
        const double t = static_cast<double>(i) / (count - 1), time_s = i / frames_per_second;
        const double u = even.parameter(t * even.length());
        glm::dvec3 position = walk(u);
        // A step every 0.53 s lifts the head by some 1.5 cm.
        position.y += 0.008 * std::sin(2 * 3.141592653589793 * time_s / 0.53);
        const glm::dvec3 ahead = walk(std::min(1.0, u + 0.01)) - walk(std::max(0.0, u - 0.01));
        // The gaze turns into the bend before the feet do, and sinks a little.
        const double bearing = std::atan2(ahead.x, -ahead.z) + 0.45 * t * t + 0.12 * std::sin(7 * t);
        const double pitch = -0.1 + 0.07 * std::sin(5 * t);
        const glm::dquat turn =
            glm::angleAxis(-bearing, glm::dvec3(0, 1, 0)) * glm::angleAxis(pitch, glm::dvec3(1, 0, 0));
        keys.push_back({time_s, {position, turn}});
    }
    return PosePath(std::move(keys), "pavilion");
}

}  // namespace

GeneratedScene make_pavilion(const GeneratorValues&) {
    SceneBuilder scene;
    const Paintwork paint = paint_all(scene);
    Site site{scene, paint};
    build_floor_and_steps(site);
    build_columns_and_roof(site);
    build_railings(site);
    build_banners(site);
    build_pedestals(site);
    build_table(site);
    build_lanterns(site);
    build_ground(site);
    build_path_and_signs(site);
    build_tower(site);
    build_boat(site);
    build_clouds(site);
    build_trees(site);
    build_cypresses(site);
    build_groves(site);
    build_pots(site);
    build_terrarium(site);
    build_vines(site);
    build_meadow(site);
    const PosePath rolling = ball_path(duration_s, frames_per_second);
    scene.object("ball", {scene.mesh("ball", sphere(ball_radius, 96, 48), paint.beach_ball)},
                 moved(glm::vec3(rolling.at(0).position_m)));

    GeneratedScene result;
    result.model = scene.finish();
    SceneDescription& description = result.description;
    description.camera_path = head_path();
    description.moving = {{"ball", rolling}};
    description.frames_per_second = frames_per_second;
    description.head_radius_m = 0.1;
    add_daylight(description);
    return result;
}

}  // namespace equistream::generate
