/// Depth at half the columns and rows: only depths that were there, the nearest of each four.
#include <equistream/depth_code.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace equistream {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
const float nan = std::nanf("");

TEST(HalfDepth, KeepsTheNearestOfEachFour) {
    FloatImage depth_m(8, 2, 1);
    const float upper[] = {3, 2, inf, inf, nan, nan, inf, nan}, lower[] = {1, 4, inf, 5, nan, nan, nan, nan};
    std::ranges::copy(upper, depth_m.pixel(0, 0));
    std::ranges::copy(lower, depth_m.pixel(0, 1));
    const FloatImage half_m = halve_depth(depth_m.view());
    ASSERT_EQ(half_m.width(), 4);
    ASSERT_EQ(half_m.height(), 1);
    EXPECT_EQ(*half_m.pixel(0, 0), 1);
    EXPECT_EQ(*half_m.pixel(1, 0), 5);
    EXPECT_TRUE(std::isnan(*half_m.pixel(2, 0)));
    EXPECT_EQ(*half_m.pixel(3, 0), inf) << "a miss is nearer than no surface";
}

TEST(HalfDepth, IsAsAPlainLoopHasIt) {
    constexpr int width = 70, height = 46;
    std::mt19937 random(5);
    FloatImage depth_m(width, height, 1);
    for (float& r : depth_m.samples())
        r = random() % 7 == 0 ? nan : random() % 5 == 0 ? inf : 0.3f + float(random() % 1000) / 100;
    const FloatImage again_m = double_depth(halve_depth(depth_m.view()).view());
    ASSERT_EQ(again_m.width(), width);
    ASSERT_EQ(again_m.height(), height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::vector<float> surfaces;
            for (int i = 0; i < 4; ++i)
                if (const float r = *depth_m.pixel(x / 2 * 2 + i % 2, y / 2 * 2 + i / 2); !std::isnan(r))
                    surfaces.push_back(r);
            const float found = *again_m.pixel(x, y);
            if (surfaces.empty())
                EXPECT_TRUE(std::isnan(found));
            else
                EXPECT_EQ(found, *std::ranges::min_element(surfaces)) << x << ", " << y;
        }
}

TEST(HalfDepth, HalvingWhatWasDoubledChangesNothing) {
    FloatImage half_m(6, 4, 1);
    for (std::size_t i = 0; i < half_m.samples().size(); ++i)
        half_m.samples()[i] = 1 + float(i);
    const FloatImage again_m = halve_depth(double_depth(half_m.view()).view());
    EXPECT_TRUE(std::ranges::equal(again_m.samples(), half_m.samples()));
}

}  // namespace
}  // namespace equistream
