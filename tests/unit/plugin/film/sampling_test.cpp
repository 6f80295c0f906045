// Stratification of samples within a pixel, and independence between pixels.
#include <plugin/film/sampling.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace equistream {
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
