// Motion against closed forms: seam, poles, rotation, and points behind a perspective camera.
#include <plugin/film/motion.h>
#include <plugin/film/sampling.h>

#include <equistream/image_motion.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

namespace equistream {
namespace {

const EquirectCamera sphere{360, 180, {}};  // one pixel is one degree

Pose at(double x, double y, double z) {
    return {{x, y, z}, glm::dquat(1, 0, 0, 0)};
}

Pose yawed(double degrees) {
    return {{0, 0, 0}, glm::angleAxis(degrees * pi / 180, glm::dvec3(0, 1, 0))};
}

TEST(SphereMotion, camera_and_point_at_rest_is_none) {
    const Motion motion(sphere, at(0, 0, 0), at(0, 0, 0));
    for (int x = 0; x < 360; x += 7)
        for (int y = 0; y < 180; ++y) {
            const glm::dvec2 pixel(x + 0.5, y + 0.5);
            EXPECT_LT(glm::length(motion.of_point(pixel, 3.0 * sphere.direction(pixel.x, pixel.y))), 1e-9);
            EXPECT_LT(glm::length(motion.of_direction(pixel)), 1e-9);
        }
}

TEST(SphereMotion, turning_the_camera_left_moves_everything_right) {
    // A yaw of +10 degrees about +Y turns the camera to its left, so that what it sees moves right by 10 columns.
    const Motion motion(sphere, yawed(0), yawed(10));
    for (const double u : {0.5, 100.5, 355.5})
        for (const double v : {0.5, 45.5, 90.0, 179.5}) {
            const glm::dvec2 moved = motion.of_direction({u, v});
            EXPECT_NEAR(moved.x, 10, 1e-9);
            EXPECT_NEAR(moved.y, 0, 1e-9);
        }
}

TEST(SphereMotion, takes_the_shortest_way_round_the_seam) {
    // Straight behind is the seam. A point that passes from 179 degrees on the right to 179 on the left moves by +2.
    const Motion motion(sphere, at(0, 0, 0), at(0, 0, 0));
    const glm::dvec2 moved = motion.of_point({359, 90}, sphere.direction(1, 90));
    EXPECT_NEAR(moved.x, 2, 1e-9);
    EXPECT_NEAR(motion.of_point({1, 90}, sphere.direction(359, 90)).x, -2, 1e-9);
}

TEST(SphereMotion, is_finite_at_the_poles_and_on_the_camera) {
    const Motion motion(sphere, at(0, 0, 0), at(1, 2, 3));
    for (const glm::dvec3& point : {glm::dvec3(1, 9, 3), glm::dvec3(1, -9, 3), glm::dvec3(1, 2, 3)}) {
        const glm::dvec2 moved = motion.of_point({0.5, 0.5}, point);
        EXPECT_TRUE(std::isfinite(moved.x) && std::isfinite(moved.y));
        EXPECT_LE(std::abs(moved.x), 180);
        EXPECT_LE(std::abs(moved.y), 180);
    }
}

TEST(SphereMotion, a_partial_range_has_no_seam) {
    const EquirectCamera window{90, 45, {-pi / 4, pi / 4, -pi / 8, pi / 8}};
    const Motion motion(window, at(0, 0, 0), at(0, 0, 0));
    const glm::dvec2 moved = motion.of_point({0.5, 22.5}, window.direction(200.5, 22.5));
    EXPECT_NEAR(moved.x, 200, 1e-9) << "out of the window, where the point is";
}

TEST(PerspectiveMotion, matches_similar_triangles) {
    const PerspectiveCamera view{400, 300, pi / 2};  // f = 200
    // One metre to the right at four metres' depth: 50 pixels to the left.
    const Motion motion(view, at(0, 0, 0), at(1, 0, 0));
    const glm::dvec2 moved = motion.of_point({200, 150}, {0, 0, -4});
    EXPECT_NEAR(moved.x, -50, 1e-9);
    EXPECT_NEAR(moved.y, 0, 1e-9);
}

TEST(PerspectiveMotion, points_behind_go_out_of_the_image_on_their_own_side) {
    const PerspectiveCamera view{400, 300, pi / 2};
    const Motion motion(view, at(0, 0, 0), at(0, 0, -10));
    const double far = perspective_limit_px(view.width, view.height);
    const glm::dvec2 centre(200, 150);
    const auto target = [&](const glm::dvec3& point) { return motion.of_point({10, 20}, point) + glm::dvec2(10, 20); };
    EXPECT_NEAR(glm::distance(target({1, 0, -5}), centre + far * glm::dvec2(1, 0)), 0, 1e-6);
    EXPECT_NEAR(glm::distance(target({0, 2, -5}), centre + far * glm::dvec2(0, -1)), 0, 1e-6);
    EXPECT_NEAR(glm::distance(target({0, 0, -5}), centre + far * glm::dvec2(1, 0)), 0, 1e-6) << "straight behind";
    EXPECT_NEAR(glm::distance(target({-3, 0, -10}), centre + far * glm::dvec2(-1, 0)), 0, 1e-6) << "just beside";
    std::mt19937 random(5);
    std::uniform_real_distribution<double> anywhere(-20, 20);
    for (int i = 0; i < 100000; ++i) {
        const glm::dvec2 p = target({anywhere(random), anywhere(random), anywhere(random)});
        ASSERT_LE(glm::distance(p, centre), far * (1 + 1e-12));
    }
}

TEST(PerspectiveMotion, is_continuous_where_a_point_falls_beside_the_camera) {
    const PerspectiveCamera view{400, 300, pi / 2};
    const Motion motion(view, at(0, 0, 0), at(0, 0, 0));
    glm::dvec2 last = motion.of_point({200, 150}, {1, 0.5, -0.2});
    for (double z = -0.2; z < 0.2; z += 1e-5) {
        const glm::dvec2 next = motion.of_point({200, 150}, {1, 0.5, z});
        ASSERT_LT(glm::distance(last, next), 60);
        last = next;
    }
}

}  // namespace

// Stratification of samples within a pixel, and independence between pixels.

namespace {

/// In which of across x down cells of the pixel the first across * down samples fall, one in each.
void expect_one_per_cell(std::uint64_t key, std::uint32_t pixel, std::uint32_t across, std::uint32_t down) {
    std::set<std::uint32_t> cells;
    for (std::uint32_t sample = 0; sample < across * down; ++sample) {
        const SubpixelOffset offset = subpixel_offset(key, pixel, sample);
        ASSERT_TRUE(offset.u >= 0 && offset.u < 1 && offset.v >= 0 && offset.v < 1);
        const auto column = static_cast<std::uint32_t>(offset.u * static_cast<float>(across));
        const auto row = static_cast<std::uint32_t>(offset.v * static_cast<float>(down));
        cells.insert(row * across + column);
    }
    ASSERT_EQ(cells.size(), across * down) << across << "x" << down << " at pixel " << pixel;
}

TEST(Sampling, powers_of_two_fall_one_into_each_cell) {
    const std::uint64_t key = frame_key(3, 17);
    for (std::uint32_t pixel = 0; pixel < 200; ++pixel) {
        expect_one_per_cell(key, pixel, 2, 2);
        expect_one_per_cell(key, pixel, 4, 4);
        expect_one_per_cell(key, pixel, 16, 1);
        expect_one_per_cell(key, pixel, 1, 16);
        expect_one_per_cell(key, pixel, 8, 8);
        expect_one_per_cell(key, pixel, 4, 16);
        expect_one_per_cell(key, pixel, 64, 1);
    }
    expect_one_per_cell(key, 5, 32, 32);
    expect_one_per_cell(key, 5, 1024, 1);
}

TEST(Sampling, pixels_are_uniform_and_independent) {
    const std::uint64_t key = frame_key(1, 0);
    const int count = 100000;
    double u = 0;
    double v = 0;
    double uu = 0;
    double neighbour = 0;
    double both = 0;
    for (int pixel = 0; pixel < count; ++pixel) {
        const auto a = subpixel_offset(key, static_cast<std::uint32_t>(pixel), 0);
        const auto b = subpixel_offset(key, static_cast<std::uint32_t>(pixel + 1), 0);
        u += a.u;
        v += a.v;
        uu += (a.u - 0.5) * (a.u - 0.5);
        neighbour += (a.u - 0.5) * (b.u - 0.5);
        both += (a.u - 0.5) * (a.v - 0.5);
    }
    // Standard errors: 0.29 / sqrt(n) of a mean, (1/12) / sqrt(n) of a product; five of them allowed.
    EXPECT_NEAR(u / count, 0.5, 5 * 0.289 / std::sqrt(count));
    EXPECT_NEAR(v / count, 0.5, 5 * 0.289 / std::sqrt(count));
    EXPECT_NEAR(uu / count, 1.0 / 12, 5 * 0.0745 / std::sqrt(count));
    EXPECT_NEAR(neighbour / count, 0, 5 * 0.0833 / std::sqrt(count));
    EXPECT_NEAR(both / count, 0, 5 * 0.0833 / std::sqrt(count));
}

TEST(Sampling, by_angle_tiles_send_as_much_to_an_eye_for_under_two_thirds_of_the_samples) {
    for (const std::uint32_t spp : {4u, 16u, 64u}) {
        const EquirectCamera whole{1920, 960, {}};
        const int side = 32, across = whole.width / side;
        const std::vector<std::uint32_t> samples = samples_by_angle(whole, side, spp);
        ASSERT_EQ(samples.size(), std::size_t(across * whole.height / side));
        double all = 0;
        for (int row = 0; row < whole.height / side; ++row) {
            double in_row = 0, steradians = 0;
            for (int tile = 0; tile < across; ++tile)
                in_row += samples[std::size_t(row * across + tile)];
            for (int y = row * side; y < (row + 1) * side; ++y)
                steradians += equirect_pixel_solid_angle(y, whole.width, whole.height, whole.range);
            const double on_the_equator = side * std::pow(2 * pi / whole.width, 2);
            // Beside the poles one sample is the least there is.
            const double wanted = std::max(1.0, spp * steradians / on_the_equator);
            EXPECT_NEAR(in_row / across, wanted, 1.0 / across + 1e-3 * spp) << "row " << row;
            all += in_row;
        }
        EXPECT_LT(all / double(samples.size()), (spp == 4 ? 0.66 : 0.65) * spp);
    }
    const EquirectCamera narrow{100, 64, {-0.3, 0.3, 0.2, 0.5}};
    for (const std::uint32_t samples : samples_by_angle(narrow, 32, 1))
        EXPECT_EQ(samples, 1u);
}

TEST(Sampling, seeds_are_distinct_over_the_whole_range) {
    const std::uint64_t key = frame_key(9, 9);
    std::set<std::uint64_t> seeds;
    for (const std::uint32_t pixel : {0u, 1u, 77u, (1u << 28) - 1})
        for (const std::uint32_t sample : {0u, 1u, (1u << 20) - 1, geometry_sample})
            seeds.insert(ray_seed(key, pixel, sample));
    EXPECT_EQ(seeds.size(), 16u);
    EXPECT_NE(frame_key(1, 0), frame_key(0, 1));
}

}  // namespace
}  // namespace equistream
