/// Between an XML's world and ours.
#include <host-adapters/mitsuba3/program/tessellate.h>
#include <host-adapters/mitsuba3/program/world_map.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace equistream::mitsuba_host {
namespace {

const std::string all_ups[] = {"x", "y", "z", "-x", "-y", "-z"};

glm::dvec3 axis_named(const std::string& up) {
    glm::dvec3 axis(0);
    axis[up.back() - 'x'] = up.front() == '-' ? -1 : 1;
    return axis;
}

/// As Mitsuba's look_at makes it: left, up, forward, origin.
Matrix34 looking(const glm::dvec3& origin, const glm::dvec3& target, const glm::dvec3& up) {
    const glm::dvec3 forward = glm::normalize(target - origin), left = glm::normalize(glm::cross(up, forward));
    const glm::dvec3 true_up = glm::cross(forward, left);
    return rows_of({glm::dvec4(left, 0), glm::dvec4(true_up, 0), glm::dvec4(forward, 0), glm::dvec4(origin, 1)});
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance = 1e-12) {
    EXPECT_LT(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " and " << b.x << " " << b.y << " " << b.z;
}

TEST(WorldMap, BringsTheChosenAxisUpAndMirrorsNothing) {
    for (const std::string& up : all_ups) {
        const WorldMap world = WorldMap::with_up(up, 1);
        expect_near(world.ours_from_mitsuba * axis_named(up), {0, 1, 0}, 1e-15);
        EXPECT_EQ(glm::determinant(world.ours_from_mitsuba), 1) << up;
    }
}

TEST(WorldMap, APoseComesBackAsItWent) {
    const Pose pose{{1, -2, 3}, glm::normalize(glm::dquat(0.3, -0.5, 0.7, 0.2))};
    for (const std::string& up : all_ups) {
        const WorldMap world = WorldMap::with_up(up, 0.01);
        const Pose back = world.pose(world.to_world(pose));
        expect_near(back.position_m, pose.position_m);
        EXPECT_NEAR(std::abs(glm::dot(back.orientation, pose.orientation)), 1, 1e-12);
    }
}

TEST(WorldMap, WhatTheSensorLooksAtIsAheadAndItsLeftIsOurLeft) {
    const glm::dvec3 origin(1, 2, 3), target(5, 2, 3), up(0, 0, 1);
    const WorldMap world = WorldMap::with_up("z", 0.1);
    const Pose pose = world.pose(looking(origin, target, up));
    expect_near(pose.position_m, world.point(origin));
    const auto seen = [&](const glm::dvec3& mitsuba) {
        return glm::conjugate(pose.orientation) * (world.point(mitsuba) - pose.position_m);
    };
    expect_near(seen(target), {0, 0, -0.4});
    expect_near(seen(origin + up), {0, 0.1, 0});
    expect_near(seen(origin + glm::dvec3(0, 1, 0)), {-0.1, 0, 0});  // left of one who looks along +X with +Z up
}

TEST(WorldMap, AMirroredOrScaledSensorLooksTheSameWay) {
    Matrix34 to_world = looking({0, 0, 0}, {0, 1, 0}, {0, 0, 1});
    const Pose pose = WorldMap{}.pose(to_world);
    for (const std::size_t column : {0, 4, 8})
        to_world[column] *= -3;
    const Pose mirrored = WorldMap{}.pose(to_world);
    EXPECT_NEAR(std::abs(glm::dot(pose.orientation, mirrored.orientation)), 1, 1e-12);
}

TEST(WorldMap, TransformsPointsAsBothWorldsSeeThem) {
    const WorldMap world = WorldMap::with_up("-x", 2);
    const Matrix34 placement{0, -1, 0, 4, 1, 0, 0, 5, 0, 0, 1, 6};
    const glm::dvec3 p(0.3, 0.7, -0.2);
    const glm::dvec3 there(matrix_of(placement) * glm::dvec4(p, 1));
    expect_near(glm::dvec3(world.transform(placement) * glm::dvec4(world.point(p), 1)), world.point(there));
}

TEST(WorldMap, FindsTheAxisNearestToTheSensorsUp) {
    EXPECT_EQ(nearest_up(looking({0, 0, 0}, {1, 1, -0.3}, {0, 0, 1})), "z");
    EXPECT_EQ(nearest_up(looking({0, 0, 0}, {1, 0, 0}, {0, -1, 0})), "-y");
}

}  // namespace

// Triangles of curved shapes keep to their tolerance, on both sides of the surface and all over it.

namespace {

struct Extent {
    double lowest = 1e30, highest = -1e30;
};

/// Of `value` at points spread over all triangles.
Extent extent(const Mesh& mesh, const std::function<double(const glm::dvec3&)>& value) {
    constexpr int steps = 6;
    Extent result;
    for (const glm::uvec3& t : mesh.triangles)
        for (int i = 0; i <= steps; ++i)
            for (int j = 0; i + j <= steps; ++j) {
                const double u = double{1} * i / steps, v = double{1} * j / steps;
                const glm::dvec3 p = (1 - u - v) * glm::dvec3(mesh.positions[t.x]) +
                                     u * glm::dvec3(mesh.positions[t.y]) + v * glm::dvec3(mesh.positions[t.z]);
                const double at = value(p);
                result = {std::min(result.lowest, at), std::max(result.highest, at)};
            }
    return result;
}

TEST(Tessellate, ASphereLiesWithinTheToleranceAndUsesIt) {
    const glm::dvec3 centre(1, 2, 3);
    const glm::dmat4 place = glm::scale(glm::translate(glm::dmat4(1), centre), glm::dvec3(0.7));
    for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
        const Tessellation shape = tessellate("Sphere", place, tolerance);
        const Extent radius = extent(shape.mesh, [&](const glm::dvec3& p) { return glm::length(p - centre); });
        EXPECT_GT(radius.lowest, 0.7 - 1.05 * tolerance - 1e-6);
        EXPECT_LT(radius.highest, 0.7 + 1.05 * tolerance + 1e-6);
        EXPECT_GT(radius.highest - radius.lowest, 0.4 * tolerance) << "more triangles than the tolerance asks for";
        EXPECT_FALSE(shape.coarser);
    }
}

TEST(Tessellate, ACylinderLiesWithinTheToleranceAndIsAsLong) {
    const glm::dmat4 place = glm::scale(glm::dmat4(1), glm::dvec3(0.5, 0.5, 3));
    const Tessellation shape = tessellate("Cylinder", place, 1e-3);
    const Extent radius = extent(shape.mesh, [](const glm::dvec3& p) { return std::hypot(p.x, p.y); });
    EXPECT_GT(radius.lowest, 0.5 - 1.05e-3);
    EXPECT_LT(radius.highest, 0.5 + 1.05e-3);
    const Extent height = extent(shape.mesh, [](const glm::dvec3& p) { return p.z; });
    EXPECT_NEAR(height.lowest, 0, 1e-6);
    EXPECT_NEAR(height.highest, 3, 1e-6);
}

TEST(Tessellate, ADiskHasItsAreaAndARectangleIsTwoTriangles) {
    const Mesh disk = tessellate("Disk", glm::dmat4(1), 1e-4).mesh;
    double area = 0;
    for (const glm::uvec3& t : disk.triangles)
        area += 0.5 * glm::length(glm::cross(disk.positions[t.y] - disk.positions[t.x],
                                             disk.positions[t.z] - disk.positions[t.x]));
    EXPECT_NEAR(area, pi, 2 * pi * 1e-4);
    const Mesh rectangle = tessellate("Rectangle", glm::dmat4(1), 1e-4).mesh;
    EXPECT_EQ(rectangle.triangles.size(), 2u);
    EXPECT_EQ(rectangle.positions.front(), glm::vec3(-1, -1, 0));
    EXPECT_EQ(rectangle.uvs.front(), glm::vec2(0, 0));
}

TEST(Tessellate, SaysWhenOneShapeWouldTakeTooManyTriangles) {
    EXPECT_TRUE(tessellate("Sphere", glm::dmat4(1), 1e-9).coarser);
}

TEST(Tessellate, KnowsWhatItKnows) {
    EXPECT_TRUE(is_analytic("Disk"));
    EXPECT_FALSE(is_analytic("SDFGrid"));
}

}  // namespace
}  // namespace equistream::mitsuba_host
