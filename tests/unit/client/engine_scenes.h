#pragma once
/// Scenes of several surfaces in closed form, and eyes in and beyond the head box, for the engines that find depth.
#include "analytic_scene.h"

#include <random>
#include <vector>

namespace equistream::test {

/// What each surface is at, so that a point can be told which it belongs to.
struct SurfaceScene {
    std::vector<Distance> surfaces;

    double operator()(const glm::dvec3& origin, const glm::dvec3& direction) const {
        double nearest = infinity;
        for (const Distance& surface : surfaces)
            nearest = std::min(nearest, surface(origin, direction));
        return nearest;
    }
};

/// An axis-aligned box from outside.
inline Distance box(const glm::dvec3& low, const glm::dvec3& high) {
    return [=](const glm::dvec3& o, const glm::dvec3& d) {
        double in = 0, out = infinity;
        for (int i = 0; i < 3; ++i) {
            const double a = (low[i] - o[i]) / d[i], b = (high[i] - o[i]) / d[i];
            in = std::max(in, std::min(a, b));
            out = std::min(out, std::max(a, b));
        }
        return in < out && in > 0 ? in : infinity;
    };
}

/// A floor, a tilted wall, two balls, a table and the sky.
inline SurfaceScene furnished() {
    using glm::dvec3;
    return {{[](const dvec3& o, const dvec3& d) {
                 return to_plane(o, d, {0, 1, 0}, -1.6);
             },
             [](const dvec3& o, const dvec3& d) {
                 return to_plane(o, d, {0.5, 0, std::sqrt(0.75)}, -4 * std::sqrt(0.75));
             },
             [](const dvec3& o, const dvec3& d) {
                 return to_sphere(o, d, {0.1, 0, -1.5}, 0.4);
             },
             [](const dvec3& o, const dvec3& d) {
                 return to_sphere(o, d, {0.6, 1.2, 1}, 0.3);
             },
             box({-1.4, -1.0, -1.2}, {-0.7, -0.6, 0.4})}};
}

/// The inside of a sphere, off the source's centre.
inline double hall(const glm::dvec3& o, const glm::dvec3& d) {
    return to_sphere(o, d, {0.3, -0.2, 0.5}, 4);
}

inline glm::dvec3 smooth_colour(const glm::dvec3& p, double) {
    return smooth(p, 1.5);
}

/// Ahead, across the seam, at both poles; within 63 mm, leaning, and far out of the box.
inline std::vector<Pose> engine_eyes() {
    return {{{0.0315, 0, 0}, {1, 0, 0, 0}},
            {{-0.063, 0, 0}, yaw_pitch(0.5, 0.1)},
            {{0.02, 0.1, -0.05}, yaw_pitch(pi, -0.2)},
            {{0.1, -0.1, 0.2}, yaw_pitch(0.3, 1.4)},
            {{0, 0.05, 0.1}, yaw_pitch(-2.5, -1.5)},
            {{0.3, 0.2, -0.4}, yaw_pitch(0.1, 0)}};
}

inline Pose random_eye(std::mt19937& random, double farthest_m) {
    std::uniform_real_distribution<double> one(-1, 1);
    glm::dvec3 p(1);
    while (glm::length(p) > 1)
        p = {one(random), one(random), one(random)};
    return {farthest_m * p, yaw_pitch(pi * one(random), 1.4 * one(random))};
}

/// The three kinds of picture an engine must read.
inline std::vector<Camera> engine_sources(int width) {
    return {EquirectCamera{width, width / 2, {}}, PerspectiveCamera{width * 2 / 3, width / 2, 2.0},
            EquirectCamera{width * 3 / 4, width * 5 / 12, {-2.4, 2.1, -1.2, 1.3}}};
}

inline FloatImage depth_from(const Distance& distance, const PerspectiveCamera& camera, const Pose& pose) {
    FloatImage depth_m(camera.width, camera.height, 1);
    AnalyticDepth(distance).cast(camera, pose, depth_m.view());
    return depth_m;
}

}  // namespace equistream::test
