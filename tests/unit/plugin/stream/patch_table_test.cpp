// Atlases packed into frame data: exact, small, and hostile bytes refused before anything is allocated from them.
#include "synthetic.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <plugin/stream/motion_table.h>
#include <plugin/stream/patch_table.h>
#include <tests/unit/atlas_fixture.h>

#include <gtest/gtest.h>

#include <cmath>
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

// Moving regions packed into frame data: exact, small, and hostile bytes refused.

namespace {

constexpr int width = 640, height = 320;

std::vector<MovingRegion> random_regions(int count, unsigned seed) {
    std::mt19937 random(seed);
    const auto number = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); };
    const auto below = [&](int end) { return std::uniform_int_distribution<int>(0, end - 1)(random); };
    std::vector<MovingRegion> regions;
    for (int i = 0; i < count; ++i) {
        MovingRegion region;
        const auto vector = [&](float size) {
            return glm::dvec3(glm::vec3(number(-size, size), number(-size, size), number(-size, size)));
        };
        region.motion = {{vector(3), vector(9)}, {vector(20), vector(1)}};
        region.near_m = number(0.1f, 4);
        region.far_m = region.near_m + number(0, 3);
        for (int y = below(height), last = std::min(height, y + below(60)); y < last; ++y)
            for (int x = below(80); x < width;) {
                const int end = std::min(width, x + 1 + below(40));
                region.runs.push_back({y, x, end});
                x = end + 1 + below(300);
            }
        regions.push_back(region);
    }
    return regions;
}

MovingRegion disc(glm::ivec2 centre, int radius) {
    MovingRegion region{{{{1, 0, 0}, {0, 0, 0}}, {}}, 1, 2, {}};
    for (int y = -radius; y <= radius; ++y) {
        const int half = int(std::sqrt(double(radius * radius - y * y)));
        region.runs.push_back({centre.y + y, centre.x - half, centre.x + half + 1});
    }
    return region;
}

TEST(MotionTable, RegionsComeBack) {
    for (unsigned seed = 0; seed < 200; ++seed) {
        const auto regions = random_regions(int(seed % 7), seed);
        EXPECT_EQ(unpack_motion_table(pack_motion_table(regions, width, height), width, height), regions) << seed;
    }
}

TEST(MotionTable, TheFirstAndLastPixelsComeBack) {
    const std::vector<MovingRegion> regions = {{{}, 1, 1, {{0, 0, 1}, {0, 3, width}, {height - 1, 0, width}}},
                                               {{}, 1, 1, {}}};
    EXPECT_EQ(unpack_motion_table(pack_motion_table(regions, width, height), width, height), regions);
}

TEST(MotionTable, WhatRestsTakesNoBytesAndAnOutlineAFewBitsARow) {
    EXPECT_TRUE(pack_motion_table({}, width, height).empty());
    const auto bytes = pack_motion_table({disc({300, 150}, 100)}, width, height);
    EXPECT_LE(bytes.size(), 1 + 56 + 201 * 9 / 8 + 8);
}

TEST(MotionTable, TruncationAtEveryByteIsAnError) {
    const auto bytes = pack_motion_table(random_regions(5, 3), width, height);
    for (std::size_t size = 1; size < bytes.size(); ++size)
        EXPECT_THROW(unpack_motion_table(std::span(bytes).first(size), width, height), WorkError) << size;
}

TEST(MotionTable, ChangedBytesAreRefusedOrSound) {
    std::mt19937 random(5);
    const auto bytes = pack_motion_table({disc({100, 100}, 40), disc({500, 90}, 20)}, width, height);
    int refused = 0;
    for (int i = 0; i < 4000; ++i) {
        auto changed = bytes;
        changed[random() % changed.size()] ^= std::uint8_t(1u << random() % 8);
        try {
            EXPECT_FALSE(moving_regions_problem(unpack_motion_table(changed, width, height), width, height));
        } catch (const WorkError&) {
            ++refused;
        }
    }
    EXPECT_GT(refused, 1000);
}

TEST(MotionTable, UnsoundRegionsAreNotPacked) {
    const auto refused = [](const MovingRegion& region) {
        EXPECT_THROW(pack_motion_table({region}, width, height), InputError);
    };
    refused({{}, 0, 1, {}});
    refused({{}, 2, 1, {}});
    refused({{{{NAN, 0, 0}, {0, 0, 0}}, {}}, 1, 1, {}});
    refused({{{}, {{0, 0, 0}, {0, INFINITY, 0}}}, 1, 1, {}});
    refused({{}, 1, 1, {{0, 5, 5}}});
    refused({{}, 1, 1, {{0, 5, width + 1}}});
    refused({{}, 1, 1, {{height, 5, 6}}});
    refused({{}, 1, 1, {{3, 5, 6}, {3, 6, 7}}});
    refused({{}, 1, 1, {{3, 5, 6}, {2, 5, 6}}});
    EXPECT_THROW(pack_motion_table(std::vector<MovingRegion>(256, {{}, 1, 1, {}}), width, height), InputError);
}

TEST(MotionTable, TravelsWithMainsPicturesAlone) {
    FrameInfo info;
    info.camera = EquirectCamera{width, height, {}};
    info.moving = random_regions(3, 8);
    const auto main = decode_frame_info(encode_frame_info(TrackRole::main, info));
    ASSERT_TRUE(main);
    EXPECT_EQ(main->info.moving, info.moving);
    const auto hidden = decode_frame_info(encode_frame_info(TrackRole::hidden, info));
    ASSERT_TRUE(hidden);
    EXPECT_TRUE(hidden->info.moving.empty());
    // A stream from before motion was added ends where its size would stand; one byte says that nothing was denoised,
    // and one that the picture is of one eye.
    const auto table = pack_motion_table(info.moving, width, height);
    auto older = encode_frame_info(TrackRole::main, info);
    older.resize(older.size() - table.size() - 2 - 1 - 1);
    const auto size = std::uint16_t(older.size() - 20);
    older[18] = std::uint8_t(size & 0xff);
    older[19] = std::uint8_t(size >> 8);
    const auto read = decode_frame_info(older);
    ASSERT_TRUE(read);
    EXPECT_TRUE(read->info.moving.empty());
    // With another track's picture it is damage: the role stands first.
    auto wrong = encode_frame_info(TrackRole::main, info);
    wrong[20] = std::uint8_t(TrackRole::hidden);
    EXPECT_THROW(decode_frame_info(wrong), WorkError);
}

TEST(MotionTable, MoreThanFitsIsRefusedInOneLine) {
    FrameInfo info;
    info.camera = EquirectCamera{4096, 4096, {}};
    MovingRegion comb{{}, 1, 1, {}};
    for (int y = 0; y < 200; ++y)
        for (int x = y % 7; x + 2 < 4096; x += 5 + y % 3)
            comb.runs.push_back({y, x, x + 1});
    info.moving = {comb};
    try {
        encode_frame_info(TrackRole::main, info);
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("motion: expected at most 32768 bytes"), std::string::npos);
    }
}

}  // namespace
}  // namespace equistream
