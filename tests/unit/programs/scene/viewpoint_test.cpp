#include <programs/scene/viewpoint.h>
#include <scenes/generate/scene_builder.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

namespace equistream {
namespace {

using namespace generate;

WorldBox bounds(const SceneModel& model) {
    return bounds_of(model, instance_transforms(model, SceneDescription{}, 0));
}

Viewpoint viewpoint(const SceneModel& model) {
    return find_viewpoint(model, bounds(model));
}

/// One shape, centred at the origin unless it is moved.
SceneModel one(Shape shape, const glm::mat4& world_from_object = glm::mat4(1)) {
    SceneBuilder scene;
    const auto mesh = scene.mesh("shape", std::move(shape), scene.material(matt("grey", glm::vec3(0.5f))));
    scene.object("shape", {mesh}, world_from_object);
    return scene.finish();
}

glm::dvec3 gaze(const Viewpoint& from) {
    return from.pose.orientation * glm::dvec3(0, 0, -1);
}

}  // namespace

TEST(Viewpoint, ARoomIsSeenFromItsMiddleAtEyeHeight) {
    const Viewpoint found = viewpoint(one(inside_out(box({6, 3, 4}))));
    EXPECT_TRUE(found.is_inside);
    EXPECT_TRUE(found.is_closed);
    const glm::dvec3 p = found.pose.position_m;
    EXPECT_NEAR(p.y, -1.5 + eye_height_m, 1e-4);
    EXPECT_LE(std::abs(p.z), 0.13) << "half a cell of the grid from the middle of the shorter side";
    EXPECT_LT(std::abs(p.x), 1.2) << "the shorter side is nearer than the end walls";
    EXPECT_NEAR(gaze(found).y, 0, 1e-9);
    EXPECT_GT(std::abs(gaze(found).x), 0.6) << "along the longer side";
}

/// A mirrored placement is wound the other way, and is still seen from inside.
TEST(Viewpoint, AMirroredRoomIsARoom) {
    const glm::mat4 mirrored = glm::scale(glm::mat4(1), glm::vec3(-1, 1, 1));
    EXPECT_TRUE(viewpoint(one(inside_out(box({6, 3, 4})), mirrored)).is_inside);
}

TEST(Viewpoint, ACourtyardIsSeenFromInside) {
    SceneBuilder scene;
    const auto grey = scene.material(matt("grey", glm::vec3(0.5f)));
    scene.add("ground", box({8, 0.1f, 8}), grey);
    for (int side = 0; side < 4; ++side)
        scene.object("wall", {scene.mesh("wall", box({8, 4, 0.2f}), grey)},
                     turned_y(static_cast<float>(side) * tau / 4) * moved({0, 2, -4}));
    const Viewpoint found = viewpoint(scene.finish());
    EXPECT_TRUE(found.is_inside);
    EXPECT_FALSE(found.is_closed);
    EXPECT_NEAR(found.pose.position_m.y, 0.05 + eye_height_m, 1e-3);
    EXPECT_LT(std::hypot(found.pose.position_m.x, found.pose.position_m.z), 1);
}

/// From inside, a solid has surfaces all around too, but they face away.
TEST(Viewpoint, ASolidIsSeenFromOutside) {
    const Viewpoint found = viewpoint(one(box({6, 5, 6})));
    EXPECT_FALSE(found.is_inside);
    EXPECT_GT(found.pose.position_m.z, 3 + 1);
}

TEST(Viewpoint, ASmallObjectIsSeenWholeFromAnArmsLength) {
    const SceneModel model = one(sphere(0.1f, 32, 16), moved({3, 1, -2}));
    const Viewpoint found = viewpoint(model);
    EXPECT_FALSE(found.is_inside);
    const glm::dvec3 to_it = glm::dvec3(3, 1, -2) - found.pose.position_m;
    EXPECT_GT(glm::length(to_it), 0.5);
    EXPECT_LT(glm::length(to_it), 1);
    EXPECT_LT(to_it.z, 0) << "from its front";
    EXPECT_GT(glm::dot(glm::normalize(to_it), gaze(found)), 1 - 1e-6);
}

TEST(Viewpoint, ATowerIsSeenFromTheGround) {
    const Viewpoint found = viewpoint(one(box({10, 40, 10}), moved({0, 20, 0})));
    EXPECT_FALSE(found.is_inside);
    EXPECT_NEAR(found.pose.position_m.y, eye_height_m, 1e-4);
    const glm::dvec3 to_it = glm::dvec3(0, 20, 0) - found.pose.position_m;
    EXPECT_GT(glm::dot(glm::normalize(to_it), gaze(found)), 1 - 1e-6);
    const double radius = 0.5 * std::sqrt(10.0 * 10 + 40 * 40 + 10 * 10);
    EXPECT_LT(std::asin(radius / glm::length(to_it)), glm::radians(30.01)) << "all of it within 60 degrees";
}

/// Above the furniture the walls are farther than between the screens, but few places are there.
TEST(Viewpoint, TheFloorIsWhereMostPlacesAre) {
    SceneBuilder scene;
    const auto grey = scene.material(matt("grey", glm::vec3(0.5f)));
    scene.add("room", inside_out(box({8, 4, 8})), grey);
    scene.object("platform", {scene.mesh("platform", box({1.8f, 1.5f, 1.8f}), grey)}, moved({0, -1.25f, 0}));
    const auto screen = scene.mesh("screen", box({0.05f, 2, 8}), grey);
    for (const float x : {-3.0f, -1.0f, 1.0f, 3.0f})
        scene.object("screen", {screen}, moved({x, -1, 0}));
    const Viewpoint found = viewpoint(scene.finish());
    EXPECT_TRUE(found.is_inside);
    EXPECT_NEAR(found.pose.position_m.y, -2 + eye_height_m, 1e-3);
}

}  // namespace equistream
