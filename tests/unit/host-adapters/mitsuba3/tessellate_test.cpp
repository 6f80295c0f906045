/// Triangles of curved shapes keep to their tolerance, on both sides of the surface and all over it.
#include <host-adapters/mitsuba3/program/tessellate.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace equistream::mitsuba_host {
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
