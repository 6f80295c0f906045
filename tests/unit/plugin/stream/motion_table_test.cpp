// Moving regions packed into frame data: exact, small, and hostile bytes refused.
#include <plugin/stream/motion_table.h>

#include <equistream/error.h>
#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace equistream {
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
    // A stream from before motion was added ends where its size would stand.
    const auto table = pack_motion_table(info.moving, width, height);
    auto older = encode_frame_info(TrackRole::main, info);
    older.resize(older.size() - table.size() - 2);
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
