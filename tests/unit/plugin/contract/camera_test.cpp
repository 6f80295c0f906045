// Poses, eyes and which axes a sphere keeps.
#include <equistream/camera.h>

#include <gtest/gtest.h>

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
}  // namespace equistream
