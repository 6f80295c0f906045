#include <plugin/film/reference_tiles.h>

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

namespace equistream {
namespace {

TEST(ReferenceTiles, TakeAFiftiethOfTheSamplesAndLieEverywhere) {
    constexpr glm::ivec2 size(1920, 960);
    std::vector<int> by_part(8);
    std::set<std::pair<int, int>> places;
    for (int frame = 0; frame < 8; ++frame) {
        const ReferenceTiles tiles = reference_tiles(size, 8, 0, frame);
        EXPECT_EQ(tiles.samples, 512u);
        EXPECT_NEAR(double(tiles.corners.size() * ReferenceTiles::pixels * tiles.samples), 0.02 * 1920 * 960 * 8,
                    0.001 * 1920 * 960 * 8);
        for (const glm::ivec2 corner : tiles.corners) {
            ++by_part[std::size_t(corner.x / 480 + corner.y / 480 * 4)];
            places.emplace(corner.x, corner.y);
            EXPECT_EQ(corner.x % ReferenceTiles::side, 0);
        }
    }
    EXPECT_GT(places.size(), 280u) << "of 288, elsewhere in every frame";
    for (const int count : by_part)
        EXPECT_NEAR(count, 36, 4);
}

TEST(ReferenceTiles, HaveMoreSamplesWhereFramesAreAccumulated) {
    EXPECT_EQ(reference_tiles({512, 256}, 4, 0, 0).samples, 256u);
    EXPECT_EQ(reference_tiles({512, 256}, 4, 32, 0).samples, 8192u);
}

TEST(ReferenceTiles, AreAtLeastOneAndWithinThePicture) {
    for (const glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(5, 3), glm::ivec2(70, 33)}) {
        const ReferenceTiles tiles = reference_tiles(size, 1, 0, 999'999'999);
        ASSERT_EQ(tiles.corners.size(), 1u);
        EXPECT_LT(tiles.corners.front().x, size.x);
        EXPECT_LT(tiles.corners.front().y, size.y);
    }
    EXPECT_LT(reference_tiles({8, 8}, 1 << 20, 1000, 0).samples, 1u << 20) << "samples are numbered in 21 bits";
}

}  // namespace
}  // namespace equistream
