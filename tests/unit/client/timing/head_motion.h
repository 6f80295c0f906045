#pragma once
/// Motion of a seated viewer's head, as a function of time: seeded and smooth.
///
/// Modelled on what is reported: a head is mostly held or turned about one axis with brief surges of acceleration
/// between (Zikan et al. 1995, "Note on dynamics of human head motions and on predictive filtering of head-set
/// orientations"); spectra fall steeply with frequency (Azuma and Bishop 1995, "A frequency-domain analysis of
/// head-motion prediction"; Blandino et al. 2021, "Head rotation model for virtual reality system level simulations",
/// who fit two exponential decays); movements from rest to rest are of minimum jerk (Flash and Hogan 1985). So: turns
/// of minimum jerk with yaw rates of 100 to 200 degrees/s at their peak, now and then slow pursuit at a constant rate,
/// rests between; on top sway in all axes of up to 2 Hz with amplitudes falling exponentially; eyes turn about the
/// neck.
#include <equistream/camera.h>

#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace equistream::test {

class HeadMotion {
public:
    HeadMotion(std::uint32_t seed, double duration_s) : random_(seed) {
        for (double t = 0; t < duration_s;) {
            t += between(0.2, 1.2);
            Turn turn{.from_s = t};
            turn.pursuit = between(0, 1) < 0.25;
            turn.yaw_rad = (between(0, 1) < 0.5 ? -1 : 1) * between(15, 80) * degree;
            turn.pitch_rad = between(-0.3, 0.3) * turn.yaw_rad;
            const double peak_rad_s = turn.pursuit ? between(15, 60) * degree : between(100, 200) * degree;
            turn.lasts_s = (turn.pursuit ? 1 : 1.875) * std::abs(turn.yaw_rad) / peak_rad_s;
            t += turn.lasts_s;
            turns_.push_back(turn);
        }
        for (auto& axis : sway_)
            for (std::size_t i = 0; i < axis.size(); ++i) {
                const double hz = 0.1 + 1.9 * double(i) / double(axis.size() - 1);
                axis[i] = {hz * between(0.95, 1.05), std::exp(-hz / 0.4), between(0, 2 * pi)};
            }
    }

    Pose at(double time_s) const {
        double yaw = sway(0, time_s) * 1.5 * degree, pitch = sway(1, time_s) * 1.5 * degree;
        for (const Turn& turn : turns_) {
            const double s = std::clamp((time_s - turn.from_s) / turn.lasts_s, 0.0, 1.0);
            const double share = turn.pursuit ? s : s * s * s * (10 + s * (6 * s - 15));
            yaw += share * turn.yaw_rad;
            pitch += share * turn.pitch_rad;
        }
        const glm::dquat orientation = glm::angleAxis(yaw, glm::dvec3(0, 1, 0)) *
                                       glm::angleAxis(std::clamp(pitch, -1.0, 1.0), glm::dvec3(1, 0, 0)) *
                                       glm::angleAxis(sway(2, time_s) * degree, glm::dvec3(0, 0, 1));
        const glm::dvec3 neck_m(0.02 * sway(3, time_s), 0.005 * sway(4, time_s), 0.02 * sway(5, time_s));
        return {neck_m + orientation * glm::dvec3(0, 0.075, -0.08), orientation};
    }

private:
    static constexpr double degree = pi / 180;
    struct Turn {
        double from_s = 0, lasts_s = 0, yaw_rad = 0, pitch_rad = 0;
        bool pursuit = false;
    };
    struct Wave {
        double hz = 0, amplitude = 0, phase = 0;
    };

    double between(double low, double high) {
        return low + (high - low) * double(random_()) / double(std::mt19937::max());
    }
    double sway(std::size_t axis, double time_s) const {
        double sum = 0;
        for (const Wave& wave : sway_[axis])
            sum += wave.amplitude * std::sin(2 * pi * wave.hz * time_s + wave.phase);
        return sum;
    }

    std::mt19937 random_;
    std::vector<Turn> turns_;
    std::array<std::array<Wave, 12>, 6> sway_{};
};

inline double degrees_between(const glm::dquat& a, const glm::dquat& b) {
    const glm::dquat d = glm::conjugate(a) * b;
    return 2 * std::atan2(std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), std::abs(d.w)) * 180 / pi;
}

// Ways to predict a head's pose that head_prediction.h was chosen among, each in a few plain lines.

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
