// What is there stays as it is; what is not lies between what is, smoothly.
#include "layer_extension.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace equistream {
namespace {

constexpr float none = std::numeric_limits<float>::quiet_NaN();
constexpr float box_m = 0.25f;

/// Islands of a few pixels at depths between 1 m and 20 m, some of them open sky.
FloatImage islands(int width, int height) {
    FloatImage depth_m(width, height, 1, none);
    std::mt19937 random(7);
    for (int i = 0; i < 40; ++i) {
        const int x = int(random() % unsigned(width - 4)), y = int(random() % unsigned(height - 4));
        const float r = i % 8 == 0 ? std::numeric_limits<float>::infinity() : 1 + float(random() % 1900) / 100;
        for (int v = 0; v < 4; ++v)
            std::fill_n(depth_m.pixel(x, y + v), 4, r);
    }
    return depth_m;
}

TEST(LayerExtension, WhatIsThereStaysAndTheRestLiesBetween) {
    const FloatImage before = islands(75, 41);
    FloatImage after = before;
    extend_depth(after, box_m);
    float nearest = std::numeric_limits<float>::infinity();
    for (const float r : before.samples())
        nearest = std::fmin(nearest, r);
    for (std::size_t i = 0; i < before.samples().size(); ++i) {
        if (std::isnan(before.samples()[i])) {
            EXPECT_GE(after.samples()[i], nearest * (1 - 1e-5f));
        } else {
            EXPECT_EQ(after.samples()[i], before.samples()[i]);
        }
    }
}

TEST(LayerExtension, OneDepthOrColourGoesEverywhere) {
    FloatImage depth_m(33, 17, 1, none);
    *depth_m.pixel(30, 2) = 5;
    ByteImage rgb(33, 17, 3);
    const std::array<std::uint8_t, 3> colour = {200, 100, 7};
    std::ranges::copy(colour, rgb.pixel(30, 2));
    extend_colour(rgb, depth_m.view());
    extend_depth(depth_m, box_m);
    for (int y = 0; y < 17; ++y)
        for (int x = 0; x < 33; ++x) {
            EXPECT_NEAR(*depth_m.pixel(x, y), 5, 1e-5);
            EXPECT_TRUE(std::ranges::equal(colour, std::span(rgb.pixel(x, y), 3)));
        }
}

/// Between two columns w goes from one's value to the other's and never back; steps stay below a few times the ramp's.
TEST(LayerExtension, IsSmooth) {
    constexpr int width = 64;
    FloatImage w(width, 32, 1);
    ByteImage there(width, 32, 1);
    for (int y = 0; y < 32; ++y) {
        *w.pixel(width - 1, y) = 1;
        *there.pixel(0, y) = *there.pixel(width - 1, y) = 1;
    }
    extend(w, there.view());
    for (int y = 0; y < 32; ++y)
        for (int x = 1; x < width; ++x) {
            const float step = *w.pixel(x, y) - *w.pixel(x - 1, y);
            EXPECT_GE(step, -1e-6f);
            EXPECT_LE(step, 0.3f);
        }
}

TEST(LayerExtension, NothingThereStaysNothing) {
    FloatImage depth_m(8, 8, 1, none);
    ByteImage rgb(8, 8, 3, 9);
    extend_colour(rgb, depth_m.view());
    extend_depth(depth_m, box_m);
    EXPECT_TRUE(std::ranges::all_of(depth_m.samples(), [](float r) { return std::isnan(r); }));
    EXPECT_TRUE(std::ranges::all_of(rgb.samples(), [](std::uint8_t c) { return c == 9; }));
}

}  // namespace
}  // namespace equistream
