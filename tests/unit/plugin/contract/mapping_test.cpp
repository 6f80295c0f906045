// The equirect and perspective mappings: both ways, everywhere, and against the paper's equation (1) put right.
#include <equistream/conventions.h>

#include <plugin/formulas/scalars.h>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace equistream {
namespace {

struct Format {
    int width, height;
    LongitudeLatitudeRange range;
};

const std::vector<Format> formats = {
    {960, 480, {}},
    {1920, 1080, {}},  // the paper's: not 2:1
    {7, 3, {}},
    {1, 1, {}},
    {360, 100, {0, 2 * pi, -0.3, 0.4}},
    {300, 200, {-1.1, 0.4, 0.2, pi / 2}},
    {64, 64, {2.5, 4.5, -pi / 2, 0.1}},  // across the seam
};

template <typename T>
double length(const Vector3<T>& d) {
    return std::sqrt(double(d.x) * d.x + double(d.y) * d.y + double(d.z) * d.z);
}

TEST(Equirect, pixel_to_direction_to_pixel_everywhere) {
    for (const Format& f : formats)
        for (int y = 0; y < f.height; ++y)
            for (int x = 0; x < f.width; ++x) {
                const PixelCoordinates<double> centre{x + 0.5, y + 0.5};
                const auto d = equirect_direction<double>(centre, f.width, f.height, f.range);
                ASSERT_NEAR(length(d), 1, 1e-15 * 8);
                const auto back = equirect_pixel<double>(d, f.width, f.height, f.range);
                ASSERT_NEAR(back.u, centre.u, 1e-9) << f.width << "x" << f.height << " at " << x << "," << y;
                ASSERT_NEAR(back.v, centre.v, 1e-9);
            }
}

TEST(Equirect, direction_to_pixel_to_direction_everywhere) {
    std::mt19937 random(1);
    std::normal_distribution<double> normal;
    for (int i = 0; i < 1000000; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
        const auto p = equirect_pixel<double>({d.x, d.y, d.z}, 960, 480, {});
        ASSERT_TRUE(p.u >= 0 && p.u <= 960 && p.v >= 0 && p.v <= 480);
        const auto back = equirect_direction<double>(p, 960, 480, {});
        ASSERT_LT(glm::distance(d, glm::dvec3(back.x, back.y, back.z)), 1e-14);
    }
}

TEST(Equirect, seam_is_one_line_with_two_names) {
    for (const double v : {0.5, 240.0, 479.5}) {
        const auto left = equirect_direction<double>({0, v}, 960, 480, {});
        const auto right = equirect_direction<double>({960, v}, 960, 480, {});
        EXPECT_NEAR(left.x, right.x, 1e-15);
        EXPECT_EQ(left.y, right.y);
        EXPECT_EQ(left.z, right.z);
    }
    // A hair to either side of straight behind lands at either edge.
    EXPECT_NEAR(equirect_pixel<double>({1e-9, 0, 1}, 960, 480, {}).u, 960, 1e-6);
    EXPECT_NEAR(equirect_pixel<double>({-1e-9, 0, 1}, 960, 480, {}).u, 0, 1e-6);
}

TEST(Equirect, poles_are_finite_and_at_the_edges) {
    const auto up = equirect_pixel<double>({0, 1, 0}, 960, 480, {});
    const auto down = equirect_pixel<double>({0, -1, 0}, 960, 480, {});
    EXPECT_TRUE(std::isfinite(up.u) && std::isfinite(down.u));
    EXPECT_EQ(up.v, 0);
    EXPECT_EQ(down.v, 480);
    // Just off the pole nothing is lost: atan2 keeps what asin would round away.
    const double tiny = 1e-12;
    EXPECT_NEAR(equirect_pixel<double>({tiny, 1, 0}, 960, 480, {}).v, tiny * 480 / pi, 1e-13);
    EXPECT_NEAR(equirect_pixel<double>({tiny, 1, 0}, 960, 480, {}).u, 720, 1e-9);
}

TEST(Equirect, orientation) {
    const auto pixel = [](double x, double y, double z) { return equirect_pixel<double>({x, y, z}, 960, 480, {}); };
    EXPECT_EQ(pixel(0, 0, -1).u, 480) << "forward, -Z, is the centre";
    EXPECT_EQ(pixel(0, 0, -1).v, 240);
    EXPECT_NEAR(pixel(1, 0, 0).u, 720, 1e-12) << "+X is right of it by a quarter";
    EXPECT_NEAR(pixel(-1, 0, 0).u, 240, 1e-12);
    EXPECT_LT(pixel(0, 1, -1).v, 240) << "up is towards the top row";
    EXPECT_NEAR(pixel(0, 1, -1).v, 120, 1e-12);
    EXPECT_GT(pixel(0, -1, -1).v, 240);
    EXPECT_GT(pixel(0.1, 0, -1).u, 480) << "not mirrored";
}

TEST(Equirect, a_direction_outside_a_partial_range_is_the_shortest_way_from_its_middle) {
    const LongitudeLatitudeRange range{2.5, 4.5, -1, 1};
    const auto pixel = [&](double longitude) {
        const auto d = direction_from_longitude_latitude(longitude, 0.0);
        return equirect_pixel<double>(d, 200, 200, range).u;
    };
    EXPECT_NEAR(pixel(2.6), 10, 1e-9);
    EXPECT_NEAR(pixel(4.4), 190, 1e-9);
    EXPECT_NEAR(pixel(2.4), -10, 1e-9);
    EXPECT_NEAR(pixel(4.6), 210, 1e-9);
    EXPECT_NEAR(pixel(0.5), -200, 1e-9);
    EXPECT_FALSE(range.closes());
    EXPECT_EQ(shortest_column_difference(190.0, 200, range), 190.0);
}

TEST(Equirect, a_range_may_close_without_being_the_full_sphere) {
    EXPECT_TRUE(LongitudeLatitudeRange{}.is_full_sphere());
    const LongitudeLatitudeRange band{-pi, pi, -1, pi / 2}, half{-pi / 2, pi / 2, -pi / 2, pi / 2};
    EXPECT_TRUE(band.closes());
    EXPECT_FALSE(band.is_full_sphere());
    EXPECT_FALSE(half.is_full_sphere());
}

TEST(Equirect, column_differences_take_the_shortest_way) {
    const LongitudeLatitudeRange full;
    EXPECT_EQ(shortest_column_difference(1.0, 360, full), 1.0);
    EXPECT_EQ(shortest_column_difference(359.0, 360, full), -1.0);
    EXPECT_EQ(shortest_column_difference(-359.0, 360, full), 1.0);
    EXPECT_EQ(shortest_column_difference(180.0, 360, full), -180.0);
    EXPECT_EQ(shortest_column_difference(-180.0, 360, full), -180.0);
    EXPECT_EQ(shortest_column_difference(0.0, 360, full), 0.0);
}

TEST(Equirect, solid_angles_sum_to_the_sphere) {
    for (const Format& f : formats) {
        double sum = 0;
        for (int y = 0; y < f.height; ++y)
            sum += f.width * equirect_pixel_solid_angle(y, f.width, f.height, f.range);
        const double wanted =
            f.range.longitude_span() * (std::sin(f.range.latitude_max) - std::sin(f.range.latitude_min));
        EXPECT_NEAR(sum, wanted, 1e-12);
        const bool full = f.range.closes() && f.range.latitude_span() > 3.1;
        EXPECT_NEAR(full ? sum : 4 * pi, 4 * pi, 1e-12);
    }
}

TEST(Equirect, jacobian_by_finite_differences_is_cos_latitude) {
    const int width = 960;
    const int height = 480;
    const double h = 1e-5;
    const auto direction = [&](double u, double v) {
        const auto d = equirect_direction<double>({u, v}, width, height, {});
        return glm::dvec3(d.x, d.y, d.z);
    };
    for (int y = 0; y < height; y += 13)
        for (int x = 0; x < width; x += 37) {
            const double u = x + 0.5;
            const double v = y + 0.5;
            const glm::dvec3 du = (direction(u + h, v) - direction(u - h, v)) / (2 * h);
            const glm::dvec3 dv = (direction(u, v + h) - direction(u, v - h)) / (2 * h);
            const double latitude = pi / 2 - v * pi / height;
            EXPECT_NEAR(glm::length(du), 2 * pi / width * std::cos(latitude), 1e-10);
            EXPECT_NEAR(glm::length(dv), pi / height, 1e-10);
            EXPECT_NEAR(glm::dot(du, dv), 0, 1e-12);
            // To the right x down = away from the viewer.
            EXPECT_GT(glm::dot(glm::cross(du, dv), direction(u, v)), 0) << "not mirrored";
            // An area element of a middling pixel agrees with the exact solid angle to second order.
            EXPECT_NEAR(glm::length(glm::cross(du, dv)) / equirect_pixel_solid_angle(y, width, height, {}), 1,
                        2e-6 + (y < 5 || y > height - 6 ? 1e-3 : 0));
        }
}

/// Rotation matrices written out, so that nothing but the sign convention of the text is used.
glm::dvec3 rotate_x(double a, const glm::dvec3& d) {
    return {d.x, std::cos(a) * d.y - std::sin(a) * d.z, std::sin(a) * d.y + std::cos(a) * d.z};
}
glm::dvec3 rotate_y(double a, const glm::dvec3& d) {
    return {std::cos(a) * d.x + std::sin(a) * d.z, d.y, -std::sin(a) * d.x + std::cos(a) * d.z};
}

TEST(Equirect, is_the_papers_equation_1_put_right) {
    const glm::dvec3 forward(0, 0, -1);
    double printed_differs = 0;
    double unturned_differs = 0;
    for (double i = 0; i <= 1; i += 1.0 / 64)
        for (double j = 0; j <= 1; j += 1.0 / 64) {
            const auto d = equirect_direction<double>({i * 960, j * 480}, 960, 480, {});
            const glm::dvec3 ours(d.x, d.y, d.z);
            const glm::dvec3 right = rotate_y(2 * pi * (0.5 - i), rotate_x(pi * (0.5 - j), forward));
            ASSERT_LT(glm::distance(ours, right), 1e-14);
            const glm::dvec3 printed = rotate_x(-pi / 4 + pi / 2 * j, rotate_y(pi * i, forward));
            const glm::dvec3 mirrored = rotate_y(2 * pi * (i - 0.5), rotate_x(pi * (0.5 - j), forward));
            ASSERT_LT(glm::distance(glm::dvec3(-ours.x, ours.y, ours.z), mirrored), 1e-14);
            const glm::dvec3 swapped = rotate_x(pi * (0.5 - j), rotate_y(2 * pi * (0.5 - i), forward));
            printed_differs = std::max(printed_differs, glm::distance(ours, printed));
            unturned_differs = std::max(unturned_differs, glm::distance(ours, swapped));
        }
    EXPECT_GT(printed_differs, 1) << "as printed it is another mapping";
    EXPECT_GT(unturned_differs, 1) << "and so it is with the rotations in the printed order";
}

TEST(Equirect, float_agrees_with_double) {
    double worst_direction = 0;
    double worst_pixel = 0;
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x < 960; ++x) {
            const auto d = equirect_direction<double>({x + 0.5, y + 0.5}, 960, 480, {});
            const auto f = equirect_direction<float>({float(x) + 0.5f, float(y) + 0.5f}, 960, 480, {});
            worst_direction = std::max(worst_direction, length(Vector3<double>{d.x - f.x, d.y - f.y, d.z - f.z}));
            const auto p = equirect_pixel<float>({float(d.x), float(d.y), float(d.z)}, 960, 480, {});
            worst_pixel = std::max({worst_pixel, std::abs(p.u - (x + 0.5)), std::abs(p.v - (y + 0.5))});
        }
    EXPECT_LT(worst_direction, 6e-7);
    EXPECT_LT(worst_pixel, 3e-4);
}

/// Those of the shared text, which rows of samples and shaders use.
TEST(SharedFormulas, map_directions_as_cameras_do) {
    for (const Format& f : formats) {
        const LongitudeLatitudeRange& range = f.range;
        const float middle = float(range.longitude_min + range.longitude_span() / 2);
        const float columns_per_radian = float(f.width / range.longitude_span());
        const float rows_per_radian = float(f.height / range.latitude_span());
        double worst = 0;
        for (int y = 0; y < f.height; ++y)
            for (int x = 0; x < f.width; ++x) {
                const auto d = equirect_direction<double>({x + 0.5, y + 0.5}, f.width, f.height, range);
                const glm::vec3 towards(d.x, d.y, d.z);
                const float u = formulas::sphere_column(towards.x, towards.z, std::remainder(middle, float(2 * pi)),
                                                        columns_per_radian, 0.5f * float(f.width));
                const float v =
                    formulas::sphere_row(towards.x, towards.y, towards.z, float(range.latitude_max), rows_per_radian);
                worst = std::max({worst, std::abs(u - (x + 0.5)), std::abs(v - (y + 0.5))});
            }
        EXPECT_LT(worst, 2e-3) << f.width << "x" << f.height;
    }
    const float focal = float(focal_length_px(160, 2.5));
    for (int y = 0; y < 90; ++y)
        for (int x = 0; x < 160; ++x) {
            const auto d = perspective_direction<float>({float(x) + 0.5f, float(y) + 0.5f}, 160, 90, 2.5);
            ASSERT_NEAR(formulas::flat_column(3 * d.x, 3 * d.z, focal, 80), x + 0.5, 1e-3);
            ASSERT_NEAR(formulas::flat_row(3 * d.y, 3 * d.z, focal, 45), y + 0.5, 1e-3);
        }
    EXPECT_FALSE(formulas::is_within(formulas::flat_column(0, 1, focal, 80), 160)) << "behind it";
}

TEST(Perspective, there_and_back) {
    for (const double fov : {0.1, pi / 2, 2.5})
        for (int y = 0; y < 90; ++y)
            for (int x = 0; x < 160; ++x) {
                const auto d = perspective_direction<double>({x + 0.5, y + 0.5}, 160, 90, fov);
                const auto p = perspective_pixel<double>({3 * d.x, 3 * d.y, 3 * d.z}, 160, 90, fov);
                ASSERT_NEAR(p.u, x + 0.5, 1e-9);
                ASSERT_NEAR(p.v, y + 0.5, 1e-9);
                const auto f = perspective_direction<float>({float(x) + 0.5f, float(y) + 0.5f}, 160, 90, fov);
                ASSERT_NEAR(f.x, d.x, 1e-6 * (1 + std::abs(d.x)));
                ASSERT_NEAR(f.y, d.y, 1e-6 * (1 + std::abs(d.y)));
            }
}

TEST(Perspective, fov_is_horizontal_and_up_is_up) {
    EXPECT_NEAR(focal_length_px(1920, pi / 2), 960, 1e-9);
    const auto right_edge = perspective_direction<double>({160, 45}, 160, 90, pi / 2);
    EXPECT_NEAR(std::atan2(right_edge.x, -right_edge.z), pi / 4, 1e-15);
    EXPECT_EQ(right_edge.y, 0);
    EXPECT_GT(perspective_direction<double>({80, 0}, 160, 90, pi / 2).y, 0);
    EXPECT_EQ(perspective_direction<double>({80, 45}, 160, 90, pi / 2).z, -1);
}

}  // namespace
}  // namespace equistream
