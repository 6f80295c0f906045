#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace equistream {
namespace {

ByteImage noise(unsigned seed) {
    std::mt19937 random(seed);
    ByteImage picture(7, 5, 3);
    for (std::uint8_t& sample : picture.samples())
        sample = std::uint8_t(random());
    return picture;
}

TEST(StereoPacking, LeftIsOnTheLeftOrAbove) {
    const ByteImage left = noise(1), right = noise(2);
    const ByteImage beside = packed_eyes(StereoPacking::side_by_side, left.view(), right.view());
    const ByteImage above = packed_eyes(StereoPacking::top_bottom, left.view(), right.view());
    ASSERT_EQ(beside.width(), 14);
    ASSERT_EQ(beside.height(), 5);
    ASSERT_EQ(above.width(), 7);
    ASSERT_EQ(above.height(), 10);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            EXPECT_TRUE(std::equal(left.pixel(x, y), left.pixel(x, y) + 3, beside.pixel(x, y)));
            EXPECT_TRUE(std::equal(right.pixel(x, y), right.pixel(x, y) + 3, beside.pixel(7 + x, y)));
            EXPECT_TRUE(std::equal(left.pixel(x, y), left.pixel(x, y) + 3, above.pixel(x, y)));
            EXPECT_TRUE(std::equal(right.pixel(x, y), right.pixel(x, y) + 3, above.pixel(x, 5 + y)));
        }
}

}  // namespace
}  // namespace equistream
