#include <equistream/image_motion.h>
#include <equistream/virtual_image.h>

#include <gtest/gtest.h>

namespace equistream {
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
