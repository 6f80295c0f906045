// The atlas of patches: where its pixels look from and to, the way back, and what is refused.
#include <tests/support/patch_ray.h>
#include <tests/unit/atlas_fixture.h>

#include <equistream/patches.h>

#include <gtest/gtest.h>

#include <map>
#include <tuple>

namespace equistream {
namespace {

using Slot = PatchAtlas::Slot;

TEST(Patches, APixelLooksAlongItsAuxiliarySphere) {
    const PatchAtlas atlas = testing::random_atlas(9, 5, 1);
    ASSERT_FALSE(patch_atlas_problem(atlas));
    int looked_at = 0;
    for (int y = 0; y < atlas.height(); ++y)
        for (int x = 0; x < atlas.width(); ++x) {
            const Slot& slot = atlas.slots[static_cast<std::size_t>(y / 16 * 9 + x / 16)];
            EXPECT_EQ(slot, atlas.slot_at(x, y));
            if (!slot.used)
                continue;
            ++looked_at;
            const PatchRay ray = patch_ray(atlas, x, y, x + 0.5, y + 0.5);
            EXPECT_EQ(ray.origin_m, atlas.offsets_m[slot.offset_index]);
            // The formula of conventions.h by hand.
            const double l = 2 * pi * ((slot.block_x * 16 + x % 16 + 0.5) / 500 - 0.5);
            const double p = pi * (0.5 - (slot.block_y * 16 + y % 16 + 0.5) / 243);
            const glm::dvec3 expected(std::cos(p) * std::sin(l), std::sin(p), -std::cos(p) * std::cos(l));
            EXPECT_LT(glm::distance(ray.direction, expected), 1e-13);
        }
    EXPECT_EQ(looked_at, static_cast<int>(atlas.used_slots()) * 256);
}

TEST(Patches, TheWayBackIsThatOfASearch) {
    const PatchAtlas atlas = testing::random_atlas(17, 11, 2);
    const PatchSlots index(atlas);
    std::map<std::tuple<int, int, int>, int> first;
    for (std::size_t i = 0; i < atlas.slots.size(); ++i)
        if (const Slot& s = atlas.slots[i]; s.used)
            first.try_emplace({s.offset_index, s.block_x, s.block_y}, static_cast<int>(i));
    for (int k = 0; k < 7; ++k)
        for (int y = 0; y < atlas.sphere_height; ++y)
            for (int x = 0; x < atlas.sphere_width; ++x) {
                const auto found = first.find({k, x / 16, y / 16});
                const auto pixel = index.atlas_pixel(k, x, y);
                ASSERT_EQ(pixel.has_value(), found != first.end());
                ASSERT_EQ(index.slot_of(k, x / 16, y / 16), pixel ? found->second : -1);
                if (!pixel)
                    continue;
                const auto at = patch_sphere_pixel(atlas, pixel->x, pixel->y, pixel->x, pixel->y);
                ASSERT_EQ(at.u, x);
                ASSERT_EQ(at.v, y);
            }
}

/// Blocks at the right and lower border reach beyond the grid: round the seam, over the pole.
TEST(Patches, BorderBlocksGoOnRoundTheSphere) {
    PatchAtlas atlas = testing::random_atlas(1, 1, 3);
    atlas.slots[0] = {2, static_cast<std::uint16_t>(atlas.block_columns() - 1), 4, true};
    const int beyond = atlas.block_columns() * 16 - 1;  // a column of the block that the grid has not
    ASSERT_GE(beyond, atlas.sphere_width);
    EXPECT_LT(glm::distance(patch_ray(atlas, 15, 3, 15.5, 3.5).direction,
                            atlas.sphere().direction(beyond - atlas.sphere_width + 0.5, 4 * 16 + 3.5)),
              1e-13);
    atlas.slots[0] = {2, 3, static_cast<std::uint16_t>(atlas.block_rows() - 1), true};
    const glm::dvec3 d = patch_ray(atlas, 5, 15, 5.5, 15.5).direction;
    EXPECT_NEAR(glm::length(d), 1, 1e-13);
    EXPECT_LT(d.y, -0.9);
}

TEST(Patches, UnsoundAtlasesAreToldApart) {
    const PatchAtlas sound = testing::random_atlas(4, 3, 4);
    ASSERT_FALSE(patch_atlas_problem(sound));
    const auto problem = [&](auto change) {
        PatchAtlas atlas = sound;
        change(atlas);
        return patch_atlas_problem(atlas).value_or("none");
    };
    const double nan = std::nan("");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.block_side = 3; }), "expected patches of 4 to 64 pixels a side, found 3");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.block_side = 65; }), "expected patches of 4 to 64 pixels a side, found 65");
    EXPECT_NE(problem([](PatchAtlas& a) { a.sphere_width = 0; }), "none");
    EXPECT_NE(problem([](PatchAtlas& a) { a.sphere_height = max_image_side + 1; }), "none");
    EXPECT_NE(problem([&](PatchAtlas& a) { a.range.longitude_max = nan; }), "none");
    EXPECT_NE(problem([](PatchAtlas& a) { a.offsets_m.clear(); }), "none");
    EXPECT_NE(problem([](PatchAtlas& a) { a.offsets_m.resize(max_patch_offsets + 1); }), "none");
    EXPECT_NE(problem([&](PatchAtlas& a) { a.offsets_m[1].y = nan; }), "none");
    EXPECT_NE(problem([](PatchAtlas& a) { a.columns = 1 << 30; }), "none");
    EXPECT_NE(problem([](PatchAtlas& a) { a.rows = max_patch_slots / 4 + 1; }), "none");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.slots.pop_back(); }), "expected 4 x 3 slots, found 11");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.slots[5] = {7, 0, 0, true}; }), "expected an offset below 7, found 7");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.slots[5] = {0, 32, 0, true}; }), "expected a block of 32 x 16, found 32");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.slots[5] = {0, 0, 16, true}; }), "expected a block of 32 x 16, found 16");
    EXPECT_EQ(problem([](PatchAtlas& a) { a.slots[5] = {255, 9999, 9999, false}; }), "none");
}

}  // namespace
}  // namespace equistream
