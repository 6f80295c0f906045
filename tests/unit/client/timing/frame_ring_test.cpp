#include <equistream/patches.h>

#include <client/timing/frame_slots.h>
#include <tests/unit/client/counted_memory.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <numeric>
#include <random>
#include <thread>
#include <vector>

namespace equistream::test {
namespace {

constexpr double interval_s = 1.0 / 30;

FrameStamp stamp(std::int64_t number) {
    return {
        .number = number, .frame_time_s = double(number) * interval_s, .arrival_s = double(number) * interval_s + 1};
}

using Ring = FrameRing<std::int64_t>;

Delivery deliver(Ring& ring, std::int64_t number) {
    ring.writable() = number;
    return ring.deliver(stamp(number));
}

std::vector<std::int64_t> shown(Ring& ring, double frame_time_s) {
    std::vector<std::int64_t> numbers;
    for (const std::size_t slot : ring.show(frame_time_s)) {
        EXPECT_EQ(ring.payload(slot), ring.stamp(slot).number);
        numbers.push_back(ring.payload(slot));
    }
    return numbers;
}

using Numbers = std::vector<std::int64_t>;

TEST(FrameRing, ShowsTheNewestOfItsTimeAndThoseBeforeIt) {
    Ring ring({.kept = 3, .capacity = 10});
    EXPECT_EQ(shown(ring, 5), Numbers{});
    for (std::int64_t i = 0; i < 6; ++i)
        EXPECT_EQ(deliver(ring, i), Delivery::in_order);
    EXPECT_EQ(shown(ring, -0.01), Numbers{});
    EXPECT_EQ(shown(ring, 0), Numbers{0});
    EXPECT_EQ(shown(ring, 3.99 * interval_s), (Numbers{3, 2, 1}));
    EXPECT_EQ(shown(ring, 4 * interval_s), (Numbers{4, 3, 2}));
    EXPECT_EQ(shown(ring, 100), (Numbers{5, 4, 3}));
    EXPECT_EQ(shown(ring, 100), (Numbers{5, 4, 3}));  // the server is late: still there
}

TEST(FrameRing, TellsApartHowFramesCome) {
    Ring ring({.kept = 2, .capacity = 12});
    EXPECT_EQ(deliver(ring, 10), Delivery::in_order);
    EXPECT_EQ(deliver(ring, 12), Delivery::in_order);
    EXPECT_EQ(deliver(ring, 11), Delivery::out_of_order);
    EXPECT_EQ(deliver(ring, 11), Delivery::doubled);
    EXPECT_EQ(deliver(ring, 15), Delivery::in_order);
    EXPECT_EQ(shown(ring, 12 * interval_s), (Numbers{12, 11}));
    EXPECT_EQ(deliver(ring, 14), Delivery::out_of_order);
    EXPECT_EQ(shown(ring, 15 * interval_s), (Numbers{15, 14}));
    EXPECT_EQ(deliver(ring, 13), Delivery::late);
    EXPECT_EQ(deliver(ring, 9), Delivery::late);
    EXPECT_EQ(deliver(ring, 15), Delivery::doubled);
    EXPECT_EQ(deliver(ring, 200), Delivery::in_order);
    EXPECT_EQ(deliver(ring, 137), Delivery::out_of_order);
    EXPECT_EQ(deliver(ring, 136), Delivery::too_old);
    EXPECT_EQ(shown(ring, 15 * interval_s), (Numbers{15, 14}));
    const DeliveryCounts counts = ring.counts();
    EXPECT_EQ(counts[Delivery::in_order], 4);
    EXPECT_EQ(counts[Delivery::out_of_order], 3);
    EXPECT_EQ(counts[Delivery::late], 2);
    EXPECT_EQ(counts[Delivery::doubled], 2);
    EXPECT_EQ(counts[Delivery::too_old], 1);
}

TEST(FrameRing, ALateFrameIsThereToFillFrom) {
    Ring ring({.kept = 3, .capacity = 10});
    deliver(ring, 1);
    deliver(ring, 3);
    EXPECT_EQ(shown(ring, 1), (Numbers{3, 1}));
    EXPECT_EQ(deliver(ring, 2), Delivery::late);
    EXPECT_EQ(shown(ring, 1), (Numbers{3, 2, 1}));
}

/// Of n frames that came at once, holes in what is left are at most about twice as wide as they had to be.
TEST(FrameRing, WhatAStallDammedUpIsThinnedEvenly) {
    Ring ring({.kept = 3, .capacity = 16});
    deliver(ring, 0);
    EXPECT_EQ(shown(ring, 0), Numbers{0});
    for (std::int64_t i = 1; i <= 90; ++i)
        deliver(ring, i);
    std::int64_t last = 0, widest = 0, frames = 0;
    for (double t = 0; t < 3.2; t += 0.01) {
        const Numbers numbers = shown(ring, t);
        if (numbers.front() != last) {
            widest = std::max(widest, numbers.front() - last);
            ++frames;
        }
        last = numbers.front();
    }
    EXPECT_EQ(last, 90);
    EXPECT_EQ(frames, 14);  // one slot shows frame 0, one is being filled
    EXPECT_LE(widest, 13);  // 90 / 14 = 6.4
    EXPECT_EQ(ring.counts().thinned, 90 - 14);
}

TEST(FrameRing, FramesThatArePastGoFirst) {
    Ring ring({.kept = 1, .capacity = 6});
    for (std::int64_t i = 0; i < 4; ++i)
        deliver(ring, i);
    EXPECT_EQ(shown(ring, 3 * interval_s), Numbers{3});
    for (std::int64_t i = 4; i < 8; ++i)
        deliver(ring, i);
    for (std::int64_t i = 4; i < 8; ++i)
        EXPECT_EQ(shown(ring, double(i) * interval_s), Numbers{i});
    EXPECT_EQ(ring.counts().thinned, 0);
}

TEST(FrameRing, TellsEveryArrivalOnce) {
    Ring ring({.kept = 1, .capacity = 4});
    for (std::int64_t i = 0; i < 20; ++i) {
        deliver(ring, i);
        deliver(ring, i);  // refused: nobody has to know
    }
    for (std::int64_t i = 0; i < 20; ++i) {
        const auto arrival = ring.next_arrival();
        ASSERT_TRUE(arrival);
        EXPECT_EQ(arrival->number, i);
        EXPECT_EQ(arrival->arrival_s, stamp(i).arrival_s);
    }
    EXPECT_FALSE(ring.next_arrival());
    for (std::int64_t i = 20; i < 1000; ++i)
        deliver(ring, i);
    std::int64_t told = 0;
    while (ring.next_arrival())
        ++told;
    EXPECT_EQ(told, 256);
}

TEST(FrameRing, NobodyAllocatesOnceItIsMade) {
    FrameRing<std::array<int, 100>> ring({.kept = 3, .capacity = 9});
    std::mt19937 random(1);
    const CountedMemory memory;
    for (std::int64_t i = 0; i < 20000; ++i) {
        ring.writable()[0] = int(i);
        ring.deliver(stamp(i - std::int64_t(random() % 4)));
        while (ring.next_arrival()) {
        }
        if (random() % 3 == 0)
            ring.show(double(i) * interval_s);
    }
    EXPECT_EQ(memory.allocations(), 0);
}

/// Pictures are never torn and the display never goes back, while both are as fast as they can and the display asks for
/// the very frames that the delivering thread is about to thin out.
TEST(FrameRing, TwoThreadsNeverMeetInASlot) {
    struct Picture {
        std::array<std::int64_t, 512> pixels{};
    };
    constexpr std::int64_t count = 300000;
    FrameRing<Picture> ring({.kept = 3, .capacity = 8});
    std::atomic<std::int64_t> delivered = -1;
    std::thread delivering([&] {
        std::mt19937 random(7);
        for (std::int64_t i = 0; i <= count; ++i) {
            // Some doubled, some out of order; the last one is neither.
            const bool again = i < count && random() % 8 == 0;
            const std::int64_t number = again ? std::max<std::int64_t>(0, i - std::int64_t(random() % 6)) : i;
            ring.writable().pixels.fill(number);
            ring.deliver(stamp(number));
            delivered = i;
        }
    });
    std::mt19937 random(8);
    std::int64_t current = -1, torn = 0, backward = 0, unsorted = 0, shows = 0, empty = 0;
    double asked_s = 0;
    for (bool last = false; !last; ++shows) {
        const std::int64_t newest = delivered;
        last = newest == count;
        asked_s = std::max(asked_s, double(last ? count : newest - std::int64_t(random() % 8)) * interval_s);
        const auto frames = ring.show(asked_s);
        empty += current >= 0 && frames.empty();
        std::int64_t newer = INT64_MAX;
        for (const std::size_t slot : frames) {
            const auto& pixels = ring.payload(slot).pixels;
            torn += std::ranges::count(pixels, ring.stamp(slot).number) != std::ptrdiff_t(pixels.size());
            unsorted += ring.stamp(slot).number >= newer;
            newer = ring.stamp(slot).number;
        }
        if (!frames.empty()) {
            backward += ring.stamp(frames[0]).number < current;
            current = ring.stamp(frames[0]).number;
        }
    }
    delivering.join();
    EXPECT_EQ(torn, 0);
    EXPECT_EQ(backward, 0);
    EXPECT_EQ(unsorted, 0);
    EXPECT_EQ(empty, 0);
    EXPECT_EQ(current, count);
    EXPECT_GT(shows, 1000);
    const DeliveryCounts counts = ring.counts();
    EXPECT_EQ(std::accumulate(counts.by.begin(), counts.by.end(), std::int64_t{0}), count + 1);
}

}  // namespace

// How much memory the way back to an atlas of patches takes, whatever size its sphere is said to be of.

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
