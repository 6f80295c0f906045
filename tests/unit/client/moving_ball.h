#pragma once
/// A ball that moves and spins before a painted room, as received pictures of any time that say how it moves.
#include <client/receive/receive.h>

#include <algorithm>
#include <cmath>

namespace equistream::test::moving_ball {

inline constexpr double room_m = 4;

struct Ball {
    glm::dvec3 centre_m;
    double radius_m = 0.5;
    glm::dvec3 velocity_m_s{0, 0, 0}, angular_rad_s{0, 0, 0};

    glm::dquat turned(double t) const {
        const double rate = glm::length(angular_rad_s);
        return rate == 0 ? glm::dquat(1, 0, 0, 0) : glm::angleAxis(rate * t, angular_rad_s / rate);
    }
    /// From a point that rests: spinning about a centre that goes straight on (object_motion.h).
    BodyMotion motion(const glm::dvec3& from_m) const {
        return {{velocity_m_s - glm::cross(angular_rad_s, centre_m - from_m), angular_rad_s},
                {-glm::cross(angular_rad_s, velocity_m_s), {0, 0, 0}}};
    }
};

struct Scene {
    Camera camera;
    Pose pose;
    Ball ball;
    /// A post that rests, between these longitudes of the camera's, nearer than all else; empty: none.
    glm::dvec2 post{0, 0};
};

inline constexpr double post_m = 0.7;

/// Smooth, so that positions tell more than the sampling does.
inline glm::dvec3 paint(const glm::dvec3& at, double scale) {
    return 128.0 + 100.0 * glm::dvec3(std::sin(scale * at.x), std::sin(scale * at.y + 1), std::cos(scale * at.z));
}

inline double hit_m(const glm::dvec3& to, const glm::dvec3& direction, double radius) {
    const double b = glm::dot(to, direction), d = b * b - glm::dot(to, to) + radius * radius;
    if (d < 0)
        return INFINITY;
    const double near = b - std::sqrt(d), far = b + std::sqrt(d);
    return near > 0 ? near : far > 0 ? far : INFINITY;
}

struct Picture {
    ReceivedPicture received;
    FloatImage depth_m;
    ByteImage ball;  ///< 1 where it is seen
};

inline Picture look(const Scene& scene, double t) {
    const int width = width_of(scene.camera), height = height_of(scene.camera);
    Picture p{{}, FloatImage(width, height, 1), ByteImage(width, height, 1)};
    p.received.rgb = ByteImage(width, height, 3);
    p.received.info.camera = scene.camera;
    p.received.info.camera_pose = scene.pose;
    const glm::dvec3 centre = scene.ball.centre_m + t * scene.ball.velocity_m_s;
    MovingRegion region{scene.ball.motion(scene.pose.position_m), 1e9f, 0, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const glm::dvec3 local = direction_of(scene.camera, x + 0.5, y + 0.5);
            const glm::dvec3 direction = scene.pose.orientation * local;
            double r = hit_m(-scene.pose.position_m, direction, room_m);
            glm::dvec3 rgb = paint(scene.pose.position_m + r * direction, 3);
            const double on_ball = hit_m(centre - scene.pose.position_m, direction, scene.ball.radius_m);
            bool is_ball = false;
            if (on_ball < r) {
                r = on_ball;
                const glm::dvec3 at = scene.pose.position_m + r * direction - centre;
                rgb = 255.0 - paint(glm::conjugate(scene.ball.turned(t)) * at, 9);
                is_ball = true;
            }
            if (const double longitude = std::atan2(local.x, -local.z);
                longitude > scene.post.x && longitude < scene.post.y) {
                r = post_m;
                rgb = {255, 255, 0};
                is_ball = false;
            }
            *p.depth_m.pixel(x, y) = float(r);
            for (int c = 0; c < 3; ++c)
                p.received.rgb.pixel(x, y)[c] = std::uint8_t(std::lround(rgb[c]));
            *p.ball.pixel(x, y) = is_ball;
            if (!is_ball)
                continue;
            region.near_m = std::min(region.near_m, float(r));
            region.far_m = std::max(region.far_m, float(r));
            if (!region.runs.empty() && region.runs.back().row == y && region.runs.back().end == x)
                ++region.runs.back().end;
            else
                region.runs.push_back({y, x, x + 1});
        }
    p.received.info.moving = {region};
    return p;
}

inline const EquirectCamera sphere{768, 384, {}};
inline const Pose turned{{0.2, 0.1, -0.1}, glm::angleAxis(0.5, glm::normalize(glm::dvec3(0.3, 1, 0.1)))};

}  // namespace equistream::test::moving_ball
