#pragma once
/// Ways to predict a head's pose that head_prediction.h was chosen among, each in a few plain lines.
#include <equistream/camera.h>

#include <glm/gtc/quaternion.hpp>

#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace equistream::test {

struct SeenPose {
    double time_s;
    Pose head;
};
/// Oldest first.
using History = std::vector<SeenPose>;
using Predict = Pose (*)(const History&, double ahead_s);

inline glm::dvec3 rotation_vector(glm::dquat q) {
    if (q.w < 0)
        q = -q;
    const glm::dvec3 v(q.x, q.y, q.z);
    const double sine = glm::length(v);
    return sine < 1e-12 ? 2.0 * v : v * (2 * std::atan2(sine, q.w) / sine);
}

/// `by.first` a rotation vector, `by.second` metres.
inline Pose moved(const Pose& head, const std::pair<glm::dvec3, glm::dvec3>& by) {
    const double angle = glm::length(by.first);
    const glm::dquat turn = angle < 1e-12 ? glm::dquat(1, 0, 0, 0) : glm::angleAxis(angle, by.first / angle);
    return {head.position_m + by.second, glm::normalize(turn * head.orientation)};
}

/// Rotation vector and metres from the newest pose.
inline std::pair<glm::dvec3, glm::dvec3> from_newest(const History& history, const SeenPose& pose) {
    const Pose& newest = history.back().head;
    return {rotation_vector(pose.head.orientation * glm::conjugate(newest.orientation)),
            pose.head.position_m - newest.position_m};
}

inline Pose hold(const History& history, double) {
    return history.back().head;
}

/// `seconds` at the velocity between the last two poses.
inline Pose moved_at_constant_speed(const History& history, double seconds) {
    const SeenPose& before = history[history.size() - 2];
    const auto [turn, move] = from_newest(history, before);
    const double share = -seconds / (history.back().time_s - before.time_s);
    return moved(history.back().head, {turn * share, move * share});
}

inline Pose constant_velocity(const History& history, double ahead_s) {
    return moved_at_constant_speed(history, ahead_s);
}

/// As OSVR's process model: velocity falls exponentially, here within 0.2 s.
inline Pose damped_velocity(const History& history, double ahead_s) {
    return moved_at_constant_speed(history, 0.2 * -std::expm1(-ahead_s / 0.2));
}

/// LaViola 2003, equations for position and, by rotation vectors, for orientation.
inline Pose double_exponential(const History& history, double ahead_s) {
    constexpr double alpha = 0.65;
    const double step_s = (history.back().time_s - history.front().time_s) / double(history.size() - 1);
    auto once = from_newest(history, history.front()), twice = once;
    for (const SeenPose& pose : history) {
        const auto [turn, move] = from_newest(history, pose);
        once = {alpha * turn + (1 - alpha) * once.first, alpha * move + (1 - alpha) * once.second};
        twice = {alpha * once.first + (1 - alpha) * twice.first, alpha * once.second + (1 - alpha) * twice.second};
    }
    const double a = alpha * ahead_s / step_s / (1 - alpha);
    return moved(history.back().head,
                 {(2 + a) * once.first - (1 + a) * twice.first, (2 + a) * once.second - (1 + a) * twice.second});
}

/// Per axis, driven by white noise of jerk, measured with white noise. It is told the noise that
/// head_prediction_test.cpp adds; of spectral densities of jerk (10, 30, 100, 300, 1000 rad/s^3 squared) it has what
/// was best at 50 ms.
inline Pose constant_acceleration_kalman(const History& history, double ahead_s) {
    constexpr double jerk = 10, noise = 0.02 * pi / 180;
    std::array<glm::dvec3, 3> turn{}, move{};  // value, velocity, acceleration
    turn.fill(glm::dvec3(0));
    move.fill(glm::dvec3(0));
    glm::dmat3 covariance(1e-2, 0, 0, 0, 1e2, 0, 0, 0, 1e4);
    double time_s = history.front().time_s;
    const auto step = [](std::array<glm::dvec3, 3>& x, double t) {
        x[0] += t * x[1] + t * t / 2 * x[2];
        x[1] += t * x[2];
    };
    turn[0] = from_newest(history, history.front()).first;
    move[0] = from_newest(history, history.front()).second;
    for (const SeenPose& pose : history) {
        const double t = pose.time_s - time_s;
        time_s = pose.time_s;
        step(turn, t);
        step(move, t);
        const glm::dmat3 forward(1, 0, 0, t, 1, 0, t * t / 2, t, 1);
        const double q = jerk * jerk * t;
        covariance = forward * covariance * glm::transpose(forward) +
                     q * glm::dmat3(t * t * t * t / 20, t * t * t / 8, t * t / 6, t * t * t / 8, t * t / 3, t / 2,
                                    t * t / 6, t / 2, 1);
        const glm::dvec3 gain = covariance[0] / (covariance[0][0] + noise * noise);
        const auto [seen_turn, seen_move] = from_newest(history, pose);
        const glm::dvec3 turn_off = seen_turn - turn[0], move_off = seen_move - move[0];
        for (int i = 0; i < 3; ++i) {
            turn[std::size_t(i)] += gain[i] * turn_off;
            move[std::size_t(i)] += gain[i] * move_off;
        }
        covariance -= glm::outerProduct(gain, glm::transpose(covariance)[0]);
    }
    step(turn, ahead_s);
    step(move, ahead_s);
    return moved(history.back().head, {turn[0], move[0]});
}

}  // namespace equistream::test
