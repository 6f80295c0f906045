#pragma once
/// Textured, moving, spinning balls inside a large textured ball: every ray, every point's past and future, and every
/// colour in closed form, in double precision.
#include <equistream/camera.h>

#include <array>
#include <cmath>
#include <optional>

namespace equistream::testing {

struct Ball {
    glm::dvec3 centre_m;    ///< at frame 0
    glm::dvec3 velocity_m;  ///< per frame
    double radius_m;
    double spin_rad;  ///< about +Y, per frame
    bool inside_out = false;

    glm::dvec3 centre(double frame) const { return centre_m + frame * velocity_m; }
    glm::dquat turn(double frame) const { return glm::angleAxis(frame * spin_rad, glm::dvec3(0, 1, 0)); }
    /// The point of the ball's own surface (unit vector) that is at a world position, and back.
    glm::dvec3 own(const glm::dvec3& world, double frame) const {
        return glm::conjugate(turn(frame)) * ((world - centre(frame)) / radius_m);
    }
    glm::dvec3 world(const glm::dvec3& own_point, double frame) const {
        return centre(frame) + radius_m * (turn(frame) * own_point);
    }
    /// Distance to the surface, if the ray (unit direction) meets it.
    std::optional<double> distance(const glm::dvec3& origin, const glm::dvec3& direction, double frame) const {
        const glm::dvec3 to = origin - centre(frame);
        const double b = glm::dot(to, direction);
        const double discriminant = b * b - glm::dot(to, to) + radius_m * radius_m;
        if (discriminant < 0)
            return std::nullopt;
        const double t = inside_out ? -b + std::sqrt(discriminant) : -b - std::sqrt(discriminant);
        return t > 0 ? std::optional(t) : std::nullopt;
    }
};

struct BallHit {
    int ball = -1;
    double distance_m = 0;
    glm::dvec3 own{0};
};

struct AnalyticScene {
    // The room; one ball straight behind (across the seam), one above and one below (the poles), one ahead.
    std::array<Ball, 5> balls{Ball{{0, 0, 0}, {0, 0, 0}, 6, 0, true}, Ball{{-0.4, 0.1, 2.5}, {0.08, 0, 0}, 0.8, 0.05},
                              Ball{{-0.2, 2.6, 0.3}, {0.06, 0, -0.05}, 0.9, -0.08},
                              Ball{{0.2, -2.6, 0.1}, {-0.05, 0.02, 0.04}, 0.9, 0.1},
                              Ball{{0.3, 0.2, -2.4}, {-0.07, 0.03, 0.04}, 0.7, 0.07}};

    BallHit trace(const glm::dvec3& origin, const glm::dvec3& direction, double frame) const {
        BallHit nearest;
        for (int i = 0; i < static_cast<int>(balls.size()); ++i) {
            const auto t = balls[static_cast<std::size_t>(i)].distance(origin, direction, frame);
            if (t && (nearest.ball < 0 || *t < nearest.distance_m))
                nearest = {i, *t, balls[static_cast<std::size_t>(i)].own(origin + *t * direction, frame)};
        }
        return nearest;
    }
    glm::dvec3 world(const BallHit& hit, double frame) const {
        return balls[static_cast<std::size_t>(hit.ball)].world(hit.own, frame);
    }
    /// Smooth, different on every ball, in [0.05, 0.95].
    static glm::dvec3 colour(const BallHit& hit) {
        const glm::dvec3 p = hit.own * (hit.ball == 0 ? 4.0 : 2.0) + glm::dvec3(hit.ball);
        return glm::dvec3(0.5) + 0.45 * glm::dvec3(std::sin(p.x + p.y), std::sin(p.y - 2 * p.z), std::cos(p.z + p.x));
    }
};

}  // namespace equistream::testing
