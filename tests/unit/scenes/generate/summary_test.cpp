#include <programs/scene/summary.h>

#include <scenes/generate/generate.h>

#include <scenes/library/polygon.h>

#include <gtest/gtest.h>

namespace equistream {
namespace {

TEST(DistanceToTriangle, FacesEdgesCornersAndSlivers) {
    const glm::dvec3 a(0, 0, 0), b(4, 0, 0), c(0, 3, 0);
    EXPECT_NEAR(distance_to_triangle({1, 1, 2}, a, b, c), 2, 1e-12);
    EXPECT_NEAR(distance_to_triangle({1, 1, -2}, a, b, c), 2, 1e-12);
    EXPECT_NEAR(distance_to_triangle({2, -3, 4}, a, b, c), 5, 1e-12);
    EXPECT_NEAR(distance_to_triangle({-3, -4, 12}, a, b, c), 13, 1e-12);
    EXPECT_NEAR(distance_to_triangle({4, 3, 0}, a, b, c), 12.0 / 5, 1e-12);
    EXPECT_NEAR(distance_to_triangle({2, 1, 0}, a, b, b), 1, 1e-12);
    EXPECT_NEAR(distance_to_triangle({0, 3, 4}, a, a, a), 5, 1e-12);
}

SceneSummary summary_of(const std::string& name, const std::vector<std::string>& options = {}) {
    const GeneratedScene scene = make_scene(find_generator(name), options);
    return summarise(scene.model, scene.description);
}

TEST(Summary, SphereFromInside) {
    const SceneSummary centred = summary_of("sphere", {"radius=2", "n=128"});
    EXPECT_NEAR(centred.nearest_m, 2, 2 * (1 - std::cos(3.15 / 128)));
    EXPECT_EQ(centred.path_length_m, 0);
    const SceneSummary aside = summary_of("sphere", {"radius=2", "n=128", "offset=0.5"});
    EXPECT_NEAR(aside.nearest_m, 1, 2 * (1 - std::cos(3.15 / 128)));
    EXPECT_NEAR(aside.box_high_m.y, 2, 1e-6);
    EXPECT_EQ(aside.emissive_triangles, aside.triangles);
}

TEST(Summary, BoundOfARoom) {
    // Nearest wall 2.2 m away, eyes within 31.5 mm: w = 0.0315 / 2.1685, in steps of 2 / (4 * 960).
    const SceneSummary room = summary_of("orientation");
    EXPECT_NEAR(room.nearest_m, 2.2, 1e-6);
    EXPECT_NEAR(room.box_radius_m, 0.0315, 1e-12);
    EXPECT_EQ(room.depth_levels, 28);
    EXPECT_EQ(room.unique_triangles, 12u);
}

TEST(Summary, PathOfTheMotionRoom) {
    const SceneSummary room = summary_of("motion");
    EXPECT_NEAR(room.path_length_m, std::sqrt(0.49 + 0.0225 + 0.25), 1e-9);
    EXPECT_NEAR(room.path_duration_s, 1, 1e-12);
    EXPECT_NEAR(room.turn_deg, glm::degrees(0.6), 0.5);
    EXPECT_EQ(room.moving_objects, 2u);
}

}  // namespace
}  // namespace equistream
