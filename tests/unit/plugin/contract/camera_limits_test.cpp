// One text decides which fields of view and which ranges of an equirect image are taken; every reader goes by it.
#include <equistream/camera_limits.h>

#include <gtest/gtest.h>

#include <limits>

namespace equistream {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(CameraLimits, FieldsOfViewAreAbove0AndBelowAHalfSpace) {
    for (const double good : {0.001, 1.5, 3.14})
        EXPECT_FALSE(camera_mismatch(PerspectiveCamera{8, 8, good})) << good;
    for (const double bad : {0.0, 1e-9, -1.0, pi, inf, nan})
        EXPECT_TRUE(camera_mismatch(PerspectiveCamera{8, 8, bad})) << bad;
    EXPECT_EQ(fov_mismatch(nan)->expected, "radians from 0.001 to pi - 0.001");
}

TEST(CameraLimits, RangesAscendWithinTheSphere) {
    const auto sphere = [](const LongitudeLatitudeRange& range) { return Camera(EquirectCamera{8, 8, range}); };
    for (const LongitudeLatitudeRange& good :
         {LongitudeLatitudeRange{}, {0, 2 * pi, -pi / 2, pi / 2}, {-3, -2.9, 1.4, 1.5}, {-5e-4, 5.1e-4, 0, 1}})
        EXPECT_FALSE(camera_mismatch(sphere(good))) << good.longitude_min << " " << good.latitude_min;
    for (const double bad : {inf, -inf, nan, 1e19, -7.0}) {
        EXPECT_TRUE(camera_mismatch(sphere({bad, 1, -1, 1}))) << bad;
        EXPECT_TRUE(camera_mismatch(sphere({-1, bad, -1, 1}))) << bad;
        EXPECT_TRUE(camera_mismatch(sphere({-1, 1, bad, 1}))) << bad;
        EXPECT_TRUE(camera_mismatch(sphere({-1, 1, -1, bad}))) << bad;
    }
    EXPECT_TRUE(camera_mismatch(sphere({1, -1, -1, 1}))) << "backward";
    EXPECT_TRUE(camera_mismatch(sphere({-pi, pi + 0.1, -1, 1}))) << "more than once round";
    EXPECT_TRUE(camera_mismatch(sphere({-pi, pi, 0, 2}))) << "beyond the pole";
    EXPECT_TRUE(camera_mismatch(sphere({0, 1e-9, -1, 1}))) << "almost nothing";
    EXPECT_TRUE(camera_mismatch(sphere({-1, 1, 0, 1e-9}))) << "almost nothing";
    EXPECT_EQ(latitudes_mismatch(0, 2)->expected, "latitudes from -pi/2 to pi/2");
    EXPECT_EQ(longitudes_mismatch(0, 1e-9)->found, "0 to 1e-09");
}

}  // namespace
}  // namespace equistream
