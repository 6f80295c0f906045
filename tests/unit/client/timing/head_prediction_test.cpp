#include "head_motion.h"

#include <client/timing/head_prediction.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

constexpr double degree = pi / 180;

Pose fitted(const History& history, double ahead_s) {
    HeadPredictor predictor;
    for (const SeenPose& pose : history)
        predictor.seen(pose.time_s, pose.head);
    return predictor.predict(history.back().time_s + ahead_s);
}

const std::map<std::string, Predict> predictors = {{"fitted", fitted},
                                                   {"hold", hold},
                                                   {"constant velocity", constant_velocity},
                                                   {"damped velocity", damped_velocity},
                                                   {"double exponential", double_exponential},
                                                   {"Kalman", constant_acceleration_kalman}};

constexpr std::array horizons_s = {0.01, 0.02, 0.035, 0.05, 0.075, 0.1};

/// Root mean squares by horizon.
struct Errors {
    std::array<double, horizons_s.size()> degrees{}, metres{};
};

/// Over 60 s of motion, seen at `hz` through a tracker with noise in every axis (a tenth of it, in centimetres, for
/// position), or at irregular times around that.
std::map<std::string, Errors> measure(double hz, double noise_deg, bool irregular = false) {
    std::map<std::string, Errors> errors;
    std::int64_t count = 0;
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const HeadMotion motion(seed, 20);
        std::mt19937 random(seed + 100);
        // Of unit variance; std::normal_distribution is another one on each platform.
        const auto noise = [&] {
            double sum = 0;
            for (int i = 0; i < 12; ++i)
                sum += double(random()) / double(std::mt19937::max());
            return sum - 6;
        };
        const auto noises = [&] {
            const double x = noise(), y = noise(), z = noise();
            return glm::dvec3(x, y, z);
        };
        History history;
        double time_s = 0;
        for (std::int64_t i = 0; time_s < 19.8; ++i) {
            time_s += (irregular ? 0.2 + 1.6 * double(random()) / double(std::mt19937::max()) : 1) / hz;
            history.push_back(
                {time_s, moved(motion.at(time_s), {noises() * noise_deg * degree, noises() * noise_deg * 1e-3})});
            if (history.size() > 60)
                history.erase(history.begin());
            if (i < 60 || i % 3 != 0)
                continue;
            ++count;
            for (const auto& [name, predict] : predictors)
                for (std::size_t h = 0; h < horizons_s.size(); ++h) {
                    const Pose predicted = predict(history, horizons_s[h]), is = motion.at(time_s + horizons_s[h]);
                    Errors& sum = errors[name];
                    sum.degrees[h] += std::pow(degrees_between(predicted.orientation, is.orientation), 2);
                    sum.metres[h] += std::pow(glm::distance(predicted.position_m, is.position_m), 2);
                }
        }
    }
    for (auto& [name, sums] : errors)
        for (std::size_t h = 0; h < horizons_s.size(); ++h) {
            sums.degrees[h] = std::sqrt(sums.degrees[h] / double(count));
            sums.metres[h] = std::sqrt(sums.metres[h] / double(count));
        }
    return errors;
}

std::string table(const std::map<std::string, Errors>& errors) {
    std::string text = "ms ahead, rms degrees (mm)\n";
    char cell[64];
    for (const auto& [name, e] : errors) {
        std::snprintf(cell, sizeof cell, "%-20s", name.c_str());
        text += cell;
        for (std::size_t h = 0; h < horizons_s.size(); ++h) {
            std::snprintf(cell, sizeof cell, "  %3.0f: %.3f (%.2f)", 1e3 * horizons_s[h], e.degrees[h],
                          1e3 * e.metres[h]);
            text += cell;
        }
        text += "\n";
    }
    return text;
}

TEST(HeadMotion, MovesAsSeatedViewersDo) {
    for (const std::uint32_t seed : {1u, 2u, 3u}) {
        const HeadMotion motion(seed, 20);
        double fastest = 0, resting_s = 0, max_jump_m = 0;
        for (double t = 0.005; t < 20; t += 0.005) {
            const double rate = degrees_between(motion.at(t - 0.005).orientation, motion.at(t).orientation) / 0.005;
            fastest = std::max(fastest, rate);
            resting_s += rate < 20 ? 0.005 : 0;
            max_jump_m = std::max(max_jump_m, glm::distance(motion.at(t - 0.005).position_m, motion.at(t).position_m));
        }
        EXPECT_GT(fastest, 120);
        EXPECT_LT(fastest, 230);
        EXPECT_GT(resting_s, 4);
        EXPECT_LT(max_jump_m, 0.005);  // 1 m/s
    }
}

TEST(HeadPrediction, BeatsHoldAndIsNeverMuchWorseThanConstantVelocity) {
    for (const double hz : {60.0, 90.0, 250.0})
        for (const double noise_deg : {0.0, 0.02, 0.05}) {
            const auto errors = measure(hz, noise_deg);
            const Errors &fit = errors.at("fitted"), &still = errors.at("hold"),
                         &steady = errors.at("constant velocity");
            SCOPED_TRACE(std::to_string(hz) + " Hz, " + std::to_string(noise_deg) + " degrees\n" + table(errors));
            for (std::size_t h = 0; h < horizons_s.size(); ++h) {
                EXPECT_LT(fit.degrees[h], 0.4 * still.degrees[h]);
                EXPECT_LT(fit.metres[h], 0.6 * still.metres[h]);
                EXPECT_LT(fit.degrees[h], 1.03 * steady.degrees[h] + 0.02);
                EXPECT_LT(fit.metres[h], 1.03 * steady.metres[h] + 5e-5);
            }
        }
}

TEST(HeadPrediction, IsTheBestOfThoseItWasChosenAmong) {
    for (const double hz : {90.0, 250.0}) {
        const auto errors = measure(hz, 0.02);
        SCOPED_TRACE(table(errors));
        for (const auto& [name, other] : errors)
            for (std::size_t h = 0; h < horizons_s.size(); ++h)
                EXPECT_LT(errors.at("fitted").degrees[h], 1.03 * other.degrees[h]) << name;
    }
}

TEST(HeadPrediction, IrregularTimesAreAsGood) {
    const auto regular = measure(90, 0.02), irregular = measure(90, 0.02, true);
    SCOPED_TRACE(table(irregular));
    for (std::size_t h = 0; h < horizons_s.size(); ++h)
        EXPECT_LT(irregular.at("fitted").degrees[h], 1.15 * regular.at("fitted").degrees[h]);
}

/// About any axis, in any rhythm, with doubled and disordered poses among them.
TEST(HeadPrediction, IsExactForConstantVelocity) {
    std::mt19937 random(5);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * double(random()) / double(std::mt19937::max());
    };
    for (int run = 0; run < 50; ++run) {
        const glm::dvec3 axis = glm::normalize(glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)));
        const double rate = uniform(-250, 250) * degree;
        const glm::dvec3 velocity(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        const glm::dquat start = glm::angleAxis(uniform(0, 6), glm::normalize(glm::dvec3(1, 2, 3)));
        const auto pose = [&](double t) {
            return Pose{glm::dvec3(1, 2, 3) + velocity * t, glm::normalize(glm::angleAxis(rate * t, axis) * start)};
        };
        HeadPredictor predictor;
        double t = uniform(0, 100);
        for (int i = 0; i < 40; ++i) {
            Pose given = pose(t);
            if (i % 3 == 0)
                given.orientation = -given.orientation;  // the same orientation
            predictor.seen(t, given);
            if (i % 4 == 0)
                predictor.seen(t, pose(t));
            if (i % 5 == 0)
                predictor.seen(t - 0.02, Pose{});  // late: no news
            if (i >= 1)
                for (const double ahead_s : {0.0, 0.03, 0.1}) {
                    const Pose predicted = predictor.predict(t + ahead_s), is = pose(t + ahead_s);
                    ASSERT_LT(degrees_between(predicted.orientation, is.orientation), 1e-5) << run << ' ' << i;
                    ASSERT_LT(glm::distance(predicted.position_m, is.position_m), 1e-7) << run << ' ' << i;
                }
            t += run % 2 == 0 ? 1.0 / 90 : uniform(0.0005, 0.03);
        }
    }
}

/// Turns of minimum jerk that end at rest.
TEST(HeadPrediction, OvershootsAStopByLessThanATenthOfWhatConstantVelocityDoes) {
    for (const double peak_deg_s : {100.0, 150.0, 200.0})
        for (const double ahead_s : {0.02, 0.035, 0.05, 0.1}) {
            const double angle_deg = 40, lasts_s = 1.875 * angle_deg / peak_deg_s;
            const auto pose = [&](double t) {
                const double s = std::clamp(t / lasts_s, 0.0, 1.0);
                return Pose{
                    {}, glm::angleAxis(angle_deg * s * s * s * (10 + s * (6 * s - 15)) * degree, glm::dvec3(0, 1, 0))};
            };
            const auto overshoot_deg = [&](Predict predict) {
                History history;
                double most = 0;
                for (int i = -20; i < 90 * (lasts_s + 0.3); ++i) {
                    history.push_back({i / 90.0, pose(i / 90.0)});
                    if (i < 0)
                        continue;
                    const double angle = rotation_vector(predict(history, ahead_s).orientation).y / degree;
                    most = std::max(most, angle - angle_deg);
                }
                return most;
            };
            const double fit = overshoot_deg(fitted), steady = overshoot_deg(constant_velocity);
            const double share = ahead_s <= 0.05 ? 0.1 : 0.67;
            EXPECT_LT(fit, share * steady) << peak_deg_s << " " << ahead_s << ": " << fit << " of " << steady;
        }
}

TEST(HeadPrediction, OnePoseIsHeldAndAGapForgets) {
    HeadPredictor predictor;
    EXPECT_FALSE(predictor.has_seen());
    predictor.seen(1, {{1, 0, 0}, {1, 0, 0, 0}});
    EXPECT_EQ(predictor.predict(1.05).position_m, glm::dvec3(1, 0, 0));
    predictor.seen(1.01, {{1.01, 0, 0}, {1, 0, 0, 0}});
    EXPECT_NEAR(predictor.predict(1.05).position_m.x, 1.05, 1e-9);
    EXPECT_NEAR(predictor.predict(9).position_m.x, 1.16, 1e-9);  // no further than 150 ms
    predictor.seen(1.5, {{5, 0, 0}, {1, 0, 0, 0}});
    EXPECT_EQ(predictor.predict(1.55).position_m, glm::dvec3(5, 0, 0));
}

}  // namespace
}  // namespace equistream::test
