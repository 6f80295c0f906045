/// How much memory the way back to an atlas of patches takes, whatever size its sphere is said to be of.
#include <tests/unit/client/counted_memory.h>

#include <equistream/patches.h>

#include <gtest/gtest.h>

namespace equistream::test {
namespace {

TEST(PatchSlots, MemoryFollowsTheSlotsAndNotTheSphere) {
    PatchAtlas atlas;
    atlas.sphere_width = atlas.sphere_height = max_image_side;
    atlas.block_side = min_patch_side;
    atlas.offsets_m.assign(max_patch_offsets, {0.02, 0, 0});
    atlas.columns = atlas.rows = 2;
    atlas.slots = {{63, 8191, 8191, true}, {}, {0, 5, 0, true}, {0, 2, 0, true}};
    ASSERT_FALSE(patch_atlas_problem(atlas));
    const CountedMemory memory;
    const PatchSlots slots(atlas);
    EXPECT_LT(memory.bytes(), std::size_t{8} << 20) << "two bytes for each block would be 8.6 GB";
    EXPECT_EQ(slots.slot_of(63, 8191, 8191), 0);
    EXPECT_EQ(slots.slot_of(0, 5, 0), 2);
    EXPECT_EQ(slots.slot_of(0, 2, 0), 3);
    EXPECT_EQ(slots.slot_of(0, 3, 0), -1);
    EXPECT_TRUE(slots.shows_any(0, 3, 5, 0));
    EXPECT_FALSE(slots.shows_any(0, 3, 4, 0));
    EXPECT_FALSE(slots.shows_any(0, 6, 8191, 0));
}

}  // namespace
}  // namespace equistream::test
