// The one bound: never exceeded by any eye in the ball, and not much larger than the worst that happens.
#include <equistream/bound.h>
#include <equistream/image_motion.h>
#include <equistream/virtual_image.h>

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <random>

namespace equistream {
namespace {

/// The angle by which an eye sees a point displaced when it is put at another distance from the centre.
double displacement_rad(const glm::dvec3& eye, const glm::dvec3& direction, double distance, double used) {
    const glm::dvec3 a = distance * direction - eye;
    const glm::dvec3 b = used * direction - eye;
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

glm::dvec3 random_direction(std::mt19937& random) {
    std::normal_distribution<double> normal;
    return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
}

TEST(Bound, is_never_exceeded) {
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(0, 1);
    int asserted = 0;
    for (int i = 0; i < 2000000; ++i) {
        const double box = std::pow(10, -2 + 2 * unit(random));
        // Distances from just outside the box to a thousand radii; eyes anywhere, often on its surface.
        const double distance = box * (1 + std::pow(10, -2 + 5 * unit(random)));
        const double used = box * (1 + std::pow(10, -2 + 5 * unit(random)));
        const double radius = unit(random) < 0.5 ? box : box * std::cbrt(unit(random));
        const glm::dvec3 eye = radius * random_direction(random);
        const double seen = displacement_rad(eye, random_direction(random), distance, used);
        const double bound = displacement_bound_rad(distance, used, box);
        // Where the sine's argument is clipped at 1 the bound says nothing but 90 degrees.
        if (std::abs(bounded_inverse_depth(distance, box) - bounded_inverse_depth(used, box)) >= 1)
            continue;
        ASSERT_LE(seen, bound + 1e-12) << "box " << box << " distance " << distance << " used " << used;
        ++asserted;
    }
    EXPECT_GT(asserted, 500000);
}

TEST(Bound, is_reached_within_a_factor) {
    // At ten box radii and beyond, the worst eye on the ball comes within a fifth of the bound for small errors.
    std::mt19937 random(3);
    for (const double distance : {10.0, 30.0, 300.0}) {
        for (const double used : {distance * 1.02, distance * 0.98}) {
            double worst = 0;
            for (int i = 0; i < 100000; ++i)
                worst = std::max(worst, displacement_rad(random_direction(random), {0, 0, -1}, distance, used));
            const double bound = displacement_bound_rad(distance, used, 1);
            EXPECT_LE(worst, bound);
            EXPECT_GT(worst, 0.75 * bound) << "at " << distance;
        }
    }
}

TEST(Bound, holds_for_points_put_at_infinity) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> unit(0, 1);
    const double infinity = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 100000; ++i) {
        const double distance = 2.1 + 1000 * unit(random);
        const glm::dvec3 eye = random_direction(random);
        const glm::dvec3 d = random_direction(random);
        // A point at infinity is seen along d from every eye.
        const glm::dvec3 a = distance * d - eye;
        const double seen = std::atan2(glm::length(glm::cross(a, d)), glm::dot(a, d));
        ASSERT_LE(seen, displacement_bound_rad(distance, infinity, 1) + 1e-12);
    }
}

TEST(Bound, inverse_depth_and_its_ends) {
    const double infinity = std::numeric_limits<double>::infinity();
    EXPECT_EQ(bounded_inverse_depth(infinity, 0.1), 0);
    EXPECT_EQ(bounded_inverse_depth(0.1, 0.1), infinity);
    EXPECT_EQ(bounded_inverse_depth(0.05, 0.1), infinity);
    EXPECT_NEAR(bounded_inverse_depth(0.2, 0.1), 1, 1e-15);
    EXPECT_EQ(displacement_bound_rad(3, 3, 0.1), 0);
    EXPECT_EQ(displacement_bound_rad(infinity, infinity, 0.1), 0);
    EXPECT_NEAR(displacement_bound_rad(0.05, 3, 0.1), std::acos(-1.0) / 2, 1e-15);
    EXPECT_NEAR(displacement_bound_rad(0.05, 0.09, 0.1), std::acos(-1.0) / 2, 1e-15);
    EXPECT_EQ(displacement_bound_rad(0.05, 0.05, 0.1), 0);
}

TEST(Bound, a_sphere_at_an_eye_has_the_other_eye_a_whole_ipd_away) {
    EXPECT_DOUBLE_EQ(head_box_radius(Eye::centre, 0.1, 0.06), 0.13);
    EXPECT_DOUBLE_EQ(head_box_radius(Eye::left, 0.1, 0.06), 0.16);
    EXPECT_DOUBLE_EQ(head_box_radius(Eye::right, 0.1, 0.06), 0.16);
}

TEST(Bound, figures_of_the_design) {
    // All of a quarter pixel at f = 960 and r_near = 0.3 m: levels of w in steps of twice the budget.
    const double step = 2 * error_budget_rad(960);
    const auto levels = [&](double near, double box) { return bounded_inverse_depth(near, box) / step; };
    EXPECT_NEAR(levels(0.3, head_box_radius_centre(0, 0.063)), 225, 1);
    EXPECT_NEAR(levels(0.3, head_box_radius_eye(0, 0.063)), 510, 1);
    EXPECT_NEAR(levels(0.5, head_box_radius_centre(0.25, 0.063)), 2470, 10);
    EXPECT_NEAR(matching_sphere_width(960), 6032, 0.5);
    EXPECT_EQ(error_budget_rad(960), error_budget_rad(960, 0.25));
    EXPECT_DOUBLE_EQ(error_budget_rad(960, 0.5), 2 * error_budget_rad(960));
}

}  // namespace

namespace {

TEST(ImageMotion, single_precision_agrees_with_double) {
    const LongitudeLatitudeRange full;
    for (double x = -1; x < 1; x += 0.13)
        for (double y = -1; y < 1; y += 0.17)
            for (double z = -1; z < 1; z += 0.19) {
                const auto exact = equirect_motion<double>({12.5, 7.5}, {x, y, z}, 64, 32, full);
                const auto single = equirect_motion<float>({12.5f, 7.5f}, {float(x), float(y), float(z)}, 64, 32, full);
                EXPECT_NEAR(shortest_column_difference(single.u - exact.u, 64, full), 0, 2e-5);
                EXPECT_NEAR(single.v, exact.v, 2e-5);
                const auto view = perspective_motion<double>({12.5, 7.5}, {x, y, z}, 64, 32, 40.0);
                const auto view_single =
                    perspective_motion<float>({12.5f, 7.5f}, {float(x), float(y), float(z)}, 64, 32, 40.0f);
                EXPECT_NEAR(view_single.u, view.u, 1e-3);
                EXPECT_NEAR(view_single.v, view.v, 1e-3);
            }
}

TEST(ImageMotion, straight_behind_is_to_the_right) {
    const auto motion = perspective_motion<double>({32, 16}, {0, 0, 1}, 64, 32, 40.0);
    EXPECT_NEAR(motion.u, perspective_limit_px(64, 32), 1e-9);
    EXPECT_NEAR(motion.v, 0, 1e-9);
}

TEST(EquirectDerivatives, are_finite_differences) {
    const LongitudeLatitudeRange part{-1.0, 2.0, -1.2, 0.9};
    const double h = 1e-5;
    for (double u = 0.5; u < 100; u += 9.7)
        for (double v = 0.5; v < 50; v += 4.9) {
            const auto d = equirect_direction_derivatives<double>({u, v}, 100, 50, part);
            const auto at = [&](double du, double dv) {
                return equirect_direction<double>({u + du, v + dv}, 100, 50, part);
            };
            EXPECT_DOUBLE_EQ(d.direction.x, at(0, 0).x);
            EXPECT_NEAR(d.per_column.x, (at(h, 0).x - at(-h, 0).x) / (2 * h), 1e-9);
            EXPECT_NEAR(d.per_column.y, (at(h, 0).y - at(-h, 0).y) / (2 * h), 1e-9);
            EXPECT_NEAR(d.per_column.z, (at(h, 0).z - at(-h, 0).z) / (2 * h), 1e-9);
            EXPECT_NEAR(d.per_row.x, (at(0, h).x - at(0, -h).x) / (2 * h), 1e-9);
            EXPECT_NEAR(d.per_row.y, (at(0, h).y - at(0, -h).y) / (2 * h), 1e-9);
            EXPECT_NEAR(d.per_row.z, (at(0, h).z - at(0, -h).z) / (2 * h), 1e-9);
        }
}

TEST(VisibleNormal, is_unit_on_the_surfaces_side_and_never_edge_on) {
    const Vector3<double> geometric{0, 0, 1};
    for (double x = -1; x < 1; x += 0.11)
        for (double y = -1; y < 1; y += 0.13)
            for (const double z : {-0.9, -0.01, 0.0, 0.01, 0.9}) {
                const Vector3<double> viewer{0.6, 0, 0.8};
                const auto n = visible_normal<double>({x, y, z}, geometric, viewer);
                EXPECT_NEAR(dot(n, n), 1, 1e-12);
                EXPECT_GE(dot(n, viewer), 0.0199);
            }
    const auto none = visible_normal<double>({0, 0, 0}, geometric, {0, 0, 1});
    EXPECT_EQ(none.z, 1);
    const auto kept = visible_normal<double>({0, 0.6, 0.8}, geometric, {0, 0, 1});
    EXPECT_NEAR(kept.y, 0.6, 1e-12);
}

}  // namespace
}  // namespace equistream
