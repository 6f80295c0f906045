/// How near a path comes to a point.
#include <host-adapters/mitsuba3/program/path_distance.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

namespace equistream::mitsuba_host {
namespace {

PosePath path_of(int keys, const std::function<glm::dvec3(int)>& at) {
    std::vector<PosePath::Key> all;
    for (int i = 0; i < keys; ++i)
        all.push_back({double(i), {at(i), glm::dquat(1, 0, 0, 0)}});
    return PosePath(std::move(all), "test");
}

/// Every line between two keys looked at.
double nearest_of_all(const PosePath& path, const glm::dvec3& point) {
    double nearest = std::numeric_limits<double>::infinity();
    const auto& keys = path.keys();
    for (std::size_t i = 0; i < keys.size(); ++i) {
        const glm::dvec3 a = keys[i].pose.position_m, b = keys[std::min(i + 1, keys.size() - 1)].pose.position_m;
        const glm::dvec3 way = b - a;
        const double share = way == glm::dvec3(0) ? 0 : glm::dot(point - a, way) / glm::dot(way, way);
        nearest = std::min(nearest, glm::distance(point, a + std::clamp(share, 0.0, 1.0) * way));
    }
    return nearest;
}

TEST(PathDistance, IsThatOfTheNearestOfAllLines) {
    const std::function<glm::dvec3(int)> ways[] = {
        [](int) { return glm::dvec3(1, 1.6, 2); },                                                    // stands still
        [](int i) { return glm::dvec3(0.05 * i, 1.6 + 0.02 * std::sin(1.3 * i), 4); },                // walks past
        [](int i) { return glm::dvec3(3 * std::cos(0.1 * i), 1.6, 3 * std::sin(0.1 * i)); },          // laps
        [](int i) { return glm::dvec3(i % 7 == 0 ? 40 : -0.3 * (i % 5), 0.1 * (i % 3), 0.01 * i); },  // leaps
    };
    for (const auto& way : ways)
        for (const int keys : {1, 2, 600}) {
            const PosePath path = path_of(keys, way);
            const PathDistance distance(path);
            for (int k = 0; k < 200; ++k) {
                const glm::dvec3 point(20 * std::sin(1.0 * k), 3 * std::cos(2.7 * k), 9 * std::sin(0.7 * k));
                EXPECT_NEAR(distance.metres_to(point), nearest_of_all(path, point), 1e-9);
            }
        }
}

TEST(PathDistance, KeysThatCannotBeNearerAreLeftOut) {
    const PathDistance walk(path_of(1001, [](int i) { return glm::dvec3(i / 128.0, 0, 0); }));
    EXPECT_EQ(walk.key_after(0, 0), 1u);
    EXPECT_EQ(walk.key_after(3, 1 / 256.0), 4u);
    EXPECT_EQ(walk.key_after(0, 1), 128u);
    EXPECT_EQ(walk.key_after(5, 0.505), 69u);
    EXPECT_EQ(walk.key_after(0, 100), 1000u);
    EXPECT_EQ(walk.key_after(1000, 0), 1001u) << "beyond the last";
    const PathDistance standing(path_of(1001, [](int) { return glm::dvec3(1, 2, 3); }));
    EXPECT_EQ(standing.key_after(0, 0), 1000u);
}

}  // namespace
}  // namespace equistream::mitsuba_host
