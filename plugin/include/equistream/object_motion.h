#pragma once
/// Motion of rigid objects in a picture, for motion extrapolation: clients move them on until the next frame arrives.
/// The camera's own movement is no part of it: that follows from poses and depth. Points are in metres from the
/// picture's camera, along the world's axes. All functions are pure.
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// Rotation, then translation: p -> rotation p + translation_m.
struct RigidTransform {
    glm::dmat3 rotation{1};
    glm::dvec3 translation_m{0, 0, 0};

    glm::dvec3 operator()(const glm::dvec3& point_m) const { return rotation * point_m + translation_m; }
    RigidTransform inverse() const {
        const glm::dmat3 back = glm::transpose(rotation);
        return {back, -(back * translation_m)};
    }
};

/// Velocity of a rigid body: its point at p moves by velocity_m_s + angular_rad_s x p.
struct Twist {
    glm::dvec3 velocity_m_s{0, 0, 0};
    glm::dvec3 angular_rad_s{0, 0, 0};

    bool operator==(const Twist&) const = default;
};

namespace rigid_motion {

/// The matrix [a] with [a] b = a x b.
inline glm::dmat3 cross_matrix(const glm::dvec3& a) {
    return {{0, a.z, -a.y}, {-a.z, 0, a.x}, {a.y, -a.x, 0}};
}
/// Below this angle, Taylor series replace sine and cosine; the terms in use are exact in double precision.
inline constexpr double small_angle_rad = 1e-4;

}  // namespace rigid_motion

/// Displacement of a body with this twist after so many seconds, which may be negative: the exponential map of SE(3), a
/// screw motion (Murray, Li, Sastry 1994, "A mathematical introduction to robotic manipulation", eq. 2.36).
inline RigidTransform moved_by(const Twist& twist, double seconds) {
    const glm::dvec3 turn = twist.angular_rad_s * seconds;
    const double angle = glm::length(turn);
    const glm::dmat3 k = rigid_motion::cross_matrix(turn);
    const bool small = angle < rigid_motion::small_angle_rad;
    const double a = small ? 1 - angle * angle / 6 : std::sin(angle) / angle;
    const double b = small ? 0.5 - angle * angle / 24 : (1 - std::cos(angle)) / (angle * angle);
    const double c = small ? 1.0 / 6 - angle * angle / 120 : (1 - a) / (angle * angle);
    const glm::dmat3 k2 = k * k;
    return {glm::dmat3(1) + a * k + b * k2, (glm::dmat3(1) + b * k + c * k2) * (twist.velocity_m_s * seconds)};
}

/// The twist that makes this displacement in `seconds`, which is not 0: the inverse of moved_by, for turns below pi.
inline Twist twist_of(const RigidTransform& transform, double seconds) {
    glm::dquat q = glm::quat_cast(transform.rotation);
    if (q.w < 0)
        q = -q;
    const glm::dvec3 axis(q.x, q.y, q.z);
    const double sine = glm::length(axis);
    const glm::dvec3 turn = sine > 0 ? axis * (2 * std::atan2(sine, q.w) / sine) : glm::dvec3(0);
    const double angle = glm::length(turn);
    const glm::dmat3 k = rigid_motion::cross_matrix(turn);
    const double c = angle < rigid_motion::small_angle_rad
                         ? 1.0 / 12
                         : (1 - angle * std::sin(angle) / (2 * (1 - std::cos(angle)))) / (angle * angle);
    return {(glm::dmat3(1) - 0.5 * k + c * (k * k)) * transform.translation_m / seconds, turn / seconds};
}

/// Motion of a body from the frame's time on: a twist that changes linearly. This is exact for rotation about a fixed
/// axis, and for a spinning body whose centre moves straight. It is right to second order for other motions.
struct BodyMotion {
    Twist twist;             ///< at the frame's time
    Twist twist_per_second;  ///< change of the twist in a second

    bool operator==(const BodyMotion&) const = default;
};

/// Displacement after so many seconds, which may be negative: the product of 16 screw motions, each with the twist in
/// the middle of its step.
inline RigidTransform moved_by(const BodyMotion& motion, double seconds) {
    constexpr int steps = 16;
    const double step_s = seconds / steps;
    RigidTransform moved;
    for (int i = 0; i < steps; ++i) {
        const double at_s = (i + 0.5) * step_s;
        const RigidTransform step =
            moved_by(Twist{motion.twist.velocity_m_s + at_s * motion.twist_per_second.velocity_m_s,
                           motion.twist.angular_rad_s + at_s * motion.twist_per_second.angular_rad_s},
                     step_s);
        moved = {step.rotation * moved.rotation, step(moved.translation_m)};
    }
    return moved;
}

/// Pixels [begin, end) of a row of the picture.
struct PixelRun {
    int row = 0, begin = 0, end = 0;

    bool operator==(const PixelRun&) const = default;
};

/// Pixels of one rigid body.
struct MovingRegion {
    BodyMotion motion;  ///< streams carry single precision
    /// Range of the body's depths, above 0 and finite. Pixels on its outline with other depths show another surface.
    float near_m = 0, far_m = 0;
    std::vector<PixelRun> runs;  ///< its pixels: row by row, from left to right; runs of a row do not touch

    std::int64_t pixels() const {
        std::int64_t sum = 0;
        for (const PixelRun& run : runs)
            sum += run.end - run.begin;
        return sum;
    }
    bool operator==(const MovingRegion&) const = default;
};

/// Most moving regions of a picture.
inline constexpr int max_moving_regions = 255;

/// Longest extrapolation without a new frame, in seconds. Measured motion has to be right within the error budget
/// (bound.h) for this time. An object that moves less than the budget in it counts as still.
inline constexpr double extrapolation_horizon_s = 0.2;

/// What is wrong with the regions of a picture of this size, in words; nullopt if they are valid.
inline std::optional<std::string> moving_regions_problem(const std::vector<MovingRegion>& regions, int width,
                                                         int height) {
    if (regions.size() > std::size_t{max_moving_regions})
        return "more than " + std::to_string(max_moving_regions) + " moving regions";
    for (const MovingRegion& region : regions) {
        for (const glm::dvec3& v :
             {region.motion.twist.velocity_m_s, region.motion.twist.angular_rad_s,
              region.motion.twist_per_second.velocity_m_s, region.motion.twist_per_second.angular_rad_s})
            for (int i = 0; i < 3; ++i)
                if (!std::isfinite(v[i]))
                    return "a motion that is not finite";
        if (!(region.near_m > 0 && region.near_m <= region.far_m && std::isfinite(region.far_m)))
            return "a moving region from " + std::to_string(region.near_m) + " m to " + std::to_string(region.far_m) +
                   " m";
        PixelRun last{-1, 0, 0};
        for (const PixelRun& run : region.runs) {
            if (run.row < last.row || run.row >= height || run.begin >= run.end || run.end > width ||
                run.begin < (run.row == last.row ? last.end + 1 : 0))
                return "pixels " + std::to_string(run.begin) + " to " + std::to_string(run.end) + " of row " +
                       std::to_string(run.row) + " in a moving region of " + std::to_string(width) + "x" +
                       std::to_string(height) + " pixels";
            last = run;
        }
    }
    return std::nullopt;
}

}  // namespace equistream
