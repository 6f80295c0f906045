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

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
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

}  // namespace equistream::test
