#include <scenes/embree/bvh_build.h>

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace equistream {
namespace {

AlphaMask random_mask(int width, int height, Wrap wrap_u, Wrap wrap_v, std::mt19937& random) {
    AlphaMask mask;
    mask.width = width;
    mask.height = height;
    mask.wrap_u = wrap_u;
    mask.wrap_v = wrap_v;
    for (int i = 0; i < width * height; ++i)
        mask.opaque.push_back(random() % 2 ? 255 : 0);
    return mask;
}

TEST(MaskBits, AgreeWithTheMaskTheyWereMadeFrom) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> coordinate(-3, 3);
    for (const auto& [width, height] : {std::pair{1, 1}, {8, 8}, {13, 5}, {64, 130}})
        for (const Wrap wrap_u : {Wrap::repeat, Wrap::clamp, Wrap::mirror})
            for (const Wrap wrap_v : {Wrap::repeat, Wrap::clamp}) {
                const AlphaMask mask = random_mask(width, height, wrap_u, wrap_v, random);
                const MaskBits bits(mask);
                for (int i = 0; i < 2000; ++i) {
                    const glm::vec2 uv{coordinate(random), coordinate(random)};
                    EXPECT_EQ(bits.covers(uv), mask.covers(uv)) << width << "x" << height << " " << uv.x << " " << uv.y;
                }
                for (const float odd : {0.0f, -0.0f, 1.0f, -1.0f, -1e-9f, 3e7f, std::numeric_limits<float>::quiet_NaN(),
                                        std::numeric_limits<float>::infinity()})
                    EXPECT_EQ(bits.covers({odd, 0.3f}), mask.covers({odd, 0.3f})) << odd;
            }
}

}  // namespace
}  // namespace equistream
