// Atlases packed into frame data: exact, small, and hostile bytes refused before anything is allocated from them.
#include <plugin/stream/patch_table.h>
#include <tests/unit/atlas_fixture.h>

#include "frame_info_matcher.h"

#include <equistream/error.h>

#include <random>

namespace equistream {
namespace {

TEST(PatchTable, EveryAtlasComesBack) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        const PatchAtlas atlas =
            testing::random_atlas(1 + static_cast<int>(seed % 37), 1 + static_cast<int>(seed % 11), seed);
        expect_same_atlas(atlas, unpack_patch_table(pack_patch_table(atlas), atlas.sphere()));
    }
}

/// One offset and one block take no bits at all.
TEST(PatchTable, TheSmallestSphereComesBack) {
    PatchAtlas atlas = testing::random_atlas(3, 1, 5);
    atlas.sphere_width = atlas.sphere_height = 7;
    atlas.offsets_m.resize(1);
    atlas.slots = {{0, 0, 0, true}, {}, {0, 0, 0, true}};
    expect_same_atlas(atlas, unpack_patch_table(pack_patch_table(atlas), atlas.sphere()));
}

TEST(PatchTable, PatchesBelowOneAnotherTakeABit) {
    PatchAtlas atlas = testing::random_atlas(120, 1, 6);
    atlas.sphere_width = 3840;
    atlas.sphere_height = 1920;
    for (std::size_t i = 0; i < 120; ++i)
        atlas.slots[i] = {3, 77, static_cast<std::uint16_t>(i), true};
    // The head and seven offsets, then 2 + 3 + 8 + 7 bits and 119 single ones.
    EXPECT_EQ(pack_patch_table(atlas).size(), 6u + 7 * 12 + (20 + 119 + 7) / 8);
}

/// The payload's size is a u16 (frame_info_codec.cpp).
TEST(PatchTable, TheLargestAtlasFitsFrameData) {
    PatchAtlas atlas = testing::random_atlas(128, 96, 7);
    ASSERT_EQ(atlas.slots.size(), static_cast<std::size_t>(max_patch_slots));
    atlas.block_side = min_patch_side;
    atlas.sphere_width = atlas.sphere_height = max_image_side;
    atlas.offsets_m.resize(max_patch_offsets);
    for (std::size_t i = 0; i < atlas.slots.size(); ++i)
        atlas.slots[i] = {static_cast<std::uint8_t>(i % 64), static_cast<std::uint16_t>(i % 8192), 1, true};
    EXPECT_LT(pack_patch_table(atlas).size(), 60000u);
}

TEST(PatchTable, TruncationAtEveryByteIsAnError) {
    const PatchAtlas atlas = testing::random_atlas(8, 8, 8);
    const auto bytes = pack_patch_table(atlas);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        const std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
        EXPECT_THROW(unpack_patch_table(cut, atlas.sphere()), WorkError) << size;
    }
}

TEST(PatchTable, DamageIsRefusedOrSound) {
    const PatchAtlas atlas = testing::random_atlas(8, 8, 9);
    const auto bytes = pack_patch_table(atlas);
    std::mt19937 random(10);
    int refused = 0;
    for (int round = 0; round < 20000; ++round) {
        auto damaged = bytes;
        for (int i = 0; i < 3; ++i)
            damaged[random() % (round % 2 == 0 ? damaged.size() : 8)] = static_cast<std::uint8_t>(random());
        try {
            EXPECT_FALSE(patch_atlas_problem(unpack_patch_table(damaged, atlas.sphere())));
        } catch (const WorkError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 1000);
    EXPECT_THROW(pack_patch_table(PatchAtlas{}), InputError);
}

}  // namespace
}  // namespace equistream
