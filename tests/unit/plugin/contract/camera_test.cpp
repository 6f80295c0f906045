// Poses, eyes and which axes a sphere keeps.
#include <equistream/camera.h>
#include <equistream/camera_limits.h>
#include <equistream/image_motion.h>

#include <gtest/gtest.h>

#include <limits>

namespace equistream {
namespace {

const glm::dquat left_turn = glm::angleAxis(pi / 2, glm::dvec3(0, 1, 0));  // looks along -X

TEST(Eyes, are_half_the_ipd_along_the_heads_x) {
    const Pose head{{1, 2, 3}, left_turn};
    const glm::dvec3 left = eye_position(head, Eye::left, 0.064);
    const glm::dvec3 right = eye_position(head, Eye::right, 0.064);
    EXPECT_EQ(eye_position(head, Eye::centre, 0.064), head.position_m);
    // Turned to the left, the head's right hand points forward (-Z).
    EXPECT_LT(glm::distance(right, glm::dvec3(1, 2, 3 - 0.032)), 1e-15);
    EXPECT_LT(glm::distance(left, glm::dvec3(1, 2, 3 + 0.032)), 1e-15);
}

TEST(AxisLocks, only_a_world_locked_sphere_ignores_the_head) {
    const Pose head{{1, 2, 3}, left_turn};
    const glm::dquat none(1, 0, 0, 0);
    const Camera sphere = EquirectCamera{64, 32, {}};
    const Camera view = PerspectiveCamera{64, 32, 1};
    EXPECT_EQ(camera_pose(sphere, head, Eye::left, 0.06, AxisLock::world).orientation, none);
    EXPECT_EQ(camera_pose(sphere, head, Eye::left, 0.06, AxisLock::path).orientation, left_turn);
    EXPECT_EQ(camera_pose(view, head, Eye::left, 0.06, AxisLock::world).orientation, left_turn);
    EXPECT_EQ(camera_pose(sphere, head, Eye::left, 0.06, AxisLock::world).position_m,
              eye_position(head, Eye::left, 0.06))
        << "the eye moves with the head all the same";
}

TEST(Cameras, agree_with_the_conventions_and_with_each_other) {
    const EquirectCamera sphere{960, 480, {}};
    const PerspectiveCamera view{101, 51, pi / 2};
    for (int y = 0; y < view.height; ++y)
        for (int x = 0; x < view.width; ++x) {
            const glm::dvec3 d = view.direction(x + 0.5, y + 0.5);
            ASSERT_NEAR(glm::length(d), 1, 1e-15 * 4);
            const glm::dvec2 p = sphere.pixel(d);
            ASSERT_LT(glm::distance(sphere.direction(p.x, p.y), d), 1e-14);
            ASSERT_LT(glm::distance(view.pixel(d), glm::dvec2(x + 0.5, y + 0.5)), 1e-9);
        }
    EXPECT_TRUE(std::isnan(view.pixel({0, 0, 1}).x)) << "behind";
    EXPECT_TRUE(std::isnan(view.pixel({1, 0, 0}).x)) << "beside";
}

TEST(Cameras, pixel_angles_at_the_middle) {
    const EquirectCamera sphere{960, 480, {}};
    const PerspectiveCamera view{1920, 1080, pi / 2};
    const double one = std::acos(glm::dot(sphere.direction(480, 240), sphere.direction(481, 240)));
    EXPECT_NEAR(sphere.pixel_angle_rad(), one, 1e-9);
    const double other = std::acos(glm::dot(view.direction(959.5, 540), view.direction(960.5, 540)));
    EXPECT_NEAR(view.pixel_angle_rad(), other, 1e-9);
}

}  // namespace

// One text decides which fields of view and which ranges of an equirect image are taken; every reader goes by it.

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

namespace {

double length(const Vector3<double>& v) {
    return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

TEST(OmnidirectionalStereo, eyes_are_an_ipd_apart_at_the_equator_and_together_at_the_poles) {
    const PoleMerge merge;
    for (const double longitude : {-3.0, -1.0, 0.0, 0.5, 2.0}) {
        for (const double latitude : {-1.0, -0.5, 0.0, 0.7, 1.04}) {
            const auto left = ods_eye_offset(longitude, latitude, -0.0315, merge);
            const auto right = ods_eye_offset(longitude, latitude, 0.0315, merge);
            EXPECT_NEAR(length({right.x - left.x, right.y - left.y, right.z - left.z}), 0.063, 1e-15);
            EXPECT_EQ(left.y, 0);
        }
        for (const double latitude : {-pi / 2, -1.4, 1.31, 1.5, pi / 2})
            EXPECT_NEAR(length(ods_eye_offset(longitude, latitude, 0.0315, merge)), 0, 1e-17);
    }
    const auto ahead = ods_eye_offset(0.0, 0.0, 0.0315, merge);
    EXPECT_GT(ahead.x, 0) << "the right eye is to the right of one who looks forward";
}

TEST(OmnidirectionalStereo, each_eye_looks_tangentially) {
    for (double longitude = -3; longitude < 3; longitude += 0.37) {
        const auto eye = ods_eye_offset(longitude, 0.4, 0.03, PoleMerge{});
        const auto d = direction_from_longitude_latitude(longitude, 0.4);
        EXPECT_NEAR(eye.x * d.x + eye.z * d.z, 0, 1e-17);
    }
}

TEST(OmnidirectionalStereo, the_fade_is_smooth) {
    const PoleMerge merge;
    const double step = 1e-5;
    double steepest = 0;
    for (double latitude = -pi / 2; latitude < pi / 2; latitude += 0.001) {
        const double before = pole_fade(latitude - step, merge), here = pole_fade(latitude, merge),
                     after = pole_fade(latitude + step, merge);
        EXPECT_GE(here, 0);
        EXPECT_LE(here, 1);
        steepest = std::max(steepest, std::abs(after - here) / step);
        // The slope has no jump: second differences stay at the curvature of a cosine.
        EXPECT_LT(std::abs(after - 2 * here + before) / (step * step),
                  1.01 * pi * pi / 2 / std::pow(pi / 12, 2) + 1e-3);
    }
    EXPECT_NEAR(steepest, pi / 2 / (pi / 12), 0.01);
}

TEST(OmnidirectionalStereo, without_merging_the_circle_stays) {
    EXPECT_EQ(pole_fade(1.5707, PoleMerge{pi, pi}), 1);
}

TEST(OmnidirectionalStereo, a_point_is_found_in_the_direction_in_which_its_eye_sees_it) {
    for (const PoleMerge merge : {PoleMerge{}, PoleMerge{pi, pi}, PoleMerge{0.2, 1.5}})
        for (double longitude = -3.1; longitude < 3.1; longitude += 0.41)
            for (double latitude = -1.5; latitude < 1.51; latitude += 0.1)
                for (const double distance : {0.3, 1.0, 30.0})
                    for (const double side : {-0.0315, 0.0315, 0.2}) {
                        if (3 * std::abs(side) > distance)
                            continue;
                        const auto eye = ods_eye_offset(longitude, latitude, side, merge);
                        const auto d = direction_from_longitude_latitude(longitude, latitude);
                        const auto seen = ods_direction<double>(
                            {eye.x + distance * d.x, distance * d.y, eye.z + distance * d.z}, side, merge);
                        EXPECT_NEAR(length({seen.x - d.x, seen.y - d.y, seen.z - d.z}), 0, 2e-5)
                            << longitude << " " << latitude << " " << distance << " " << side;
                    }
}

TEST(OmnidirectionalStereo, what_lies_inside_the_circle_has_a_direction_too) {
    const auto d = ods_direction<double>({0.001, 0.0, -0.001}, 0.0315, PoleMerge{});
    EXPECT_NEAR(length(d), 1, 1e-12);
}

}  // namespace
}  // namespace equistream
