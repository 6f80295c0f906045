/// How a live stream follows what a line carries, on lines that do not exist.
#include <programs/serve/rate.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

constexpr double sphere_s = 0.2;
/// Of a sphere, coded as asked for.
constexpr double sphere_bits = 1e6;

/// Spheres of which six steps of CRF halve the bits go down a line, one after another. Each fifth begins a group, with
/// which a line that is behind goes on.
struct Watched {
    explicit Watched(std::optional<double> max_bps, double key_frame_takes = 1)
        : rate(max_bps), key_frame(key_frame_takes) {}

    void go_on(double seconds, double line_bps) {
        for (const double end_s = now_s + seconds; now_s < end_s; now_s += sphere_s) {
            drain(line_bps);
            const bool begins_group = number++ % 5 == 0;
            if (begins_group && waiting.size() > 1 && now_s - waiting.front().first > 0.5)
                waiting.erase(waiting.begin() + 1, waiting.end());
            const double bits = (begins_group ? key_frame : 1) * sphere_bits * std::exp2(-rate.coarser() / 6);
            rate.coded(now_s, std::size_t(bits / 8), rate.coarser(), begins_group);
            rate.delivered(now_s, 1,
                           {std::int64_t(sent_bits / 8), waiting.empty() ? 0 : now_s - waiting.front().first});
            waiting.emplace_back(now_s, bits);
            behind_s.push_back(now_s - waiting.front().first);
            bps.push_back(bits / sphere_s);
            coarser.push_back(rate.coarser());
        }
    }

    void drain(double line_bps) {
        double can_bits = line_bps * sphere_s;
        while (!waiting.empty() && can_bits > 0) {
            const double taken = std::min(can_bits, waiting.front().second);
            sent_bits += taken;
            can_bits -= taken;
            waiting.front().second -= taken;
            if (waiting.front().second <= 0)
                waiting.pop_front();
        }
    }

    double latest_of_last(int spheres) const { return *std::max_element(behind_s.end() - spheres, behind_s.end()); }
    double mean_bps_of_last(int spheres) const {
        double sum = 0;
        for (auto one = bps.end() - spheres; one != bps.end(); ++one)
            sum += *one;
        return sum / spheres;
    }

    RateControl rate;
    double now_s = 0, sent_bits = 0;
    double key_frame;  // takes so many times as much as another sphere
    int number = 0;
    std::deque<std::pair<double, double>> waiting;  // since when, bits
    std::vector<double> behind_s, bps, coarser;
};

TEST(RateControl, LeavesALineAloneThatCarriesAll) {
    Watched watched(std::nullopt);
    watched.go_on(20, 20e6);
    EXPECT_EQ(watched.rate.coarser(), 0);
    EXPECT_FALSE(watched.rate.line_bps());
}

TEST(RateControl, FollowsALineThatCarriesATenthAndComesBack) {
    Watched watched(std::nullopt);
    watched.go_on(5, 20e6);
    watched.go_on(20, 0.5e6);  // a tenth of 5 Mbit/s
    EXPECT_GT(watched.rate.coarser(), 15);
    EXPECT_LT(watched.latest_of_last(25), 1) << "of the last five seconds";
    EXPECT_GT(watched.mean_bps_of_last(50), 0.3e6) << "it is used";
    EXPECT_LT(watched.mean_bps_of_last(50), 0.55e6);
    watched.go_on(20, 20e6);
    EXPECT_EQ(watched.rate.coarser(), 0);
}

TEST(RateControl, KeepsToWhatItIsTold) {
    Watched watched(1e6);
    watched.go_on(10, 20e6);
    EXPECT_NEAR(watched.mean_bps_of_last(25), 1e6, 0.05e6);
    EXPECT_NEAR(watched.rate.limit_bps(), 1e6, 1);
    watched.go_on(20, 0.5e6);  // and to the line where that carries less
    EXPECT_LT(watched.mean_bps_of_last(50), 0.55e6);
}

TEST(RateControl, KeepsToItAfterAPause) {
    Watched watched(1e6);
    watched.go_on(10, 20e6);
    watched.now_s += 60;
    watched.rate.pause();
    watched.go_on(2, 20e6);
    EXPECT_LT(*std::ranges::max_element(watched.bps.end() - 10, watched.bps.end()), 1.1e6);
}

TEST(RateControl, WhatKeyFramesTakeIsSpreadOverTheOthers) {
    Watched watched(2e6, 4);
    watched.go_on(30, 100e6);
    EXPECT_NEAR(watched.mean_bps_of_last(100), 2e6, 0.1e6);
    for (auto one = watched.coarser.end() - 99; one != watched.coarser.end(); ++one)
        EXPECT_NEAR(*one, *std::prev(one), 2.5) << "they are seen one by one";
}

TEST(RateControl, BecomesFinerNoFasterThanFourStepsASecond) {
    Watched watched(std::nullopt);
    watched.go_on(20, 0.3e6);
    const double before = watched.rate.coarser();
    ASSERT_GT(before, 20);
    watched.go_on(2, 100e6);
    EXPECT_GE(watched.rate.coarser(), before - 4 * 2 - 1e-6);
    EXPECT_LT(watched.rate.coarser(), before - 4);
}

TEST(RateControl, GivesUpSoMuchAndNoMore) {
    Watched watched(1e4);
    watched.go_on(10, 20e6);
    EXPECT_EQ(watched.rate.coarser(), RateControl::coarsest);
}

TEST(RateControl, BeginsAnewWithAnotherViewer) {
    Watched watched(std::nullopt);
    watched.go_on(10, 0.5e6);
    ASSERT_TRUE(watched.rate.line_bps());
    watched.rate.delivered(watched.now_s, 2, {0, 0});
    EXPECT_FALSE(watched.rate.line_bps());
    EXPECT_EQ(watched.rate.coarser(), 0);
}

/// One whose first sphere is coded before anything is known of its line.
TEST(RateControl, BeginsAnewWithAnotherViewerAfterAPause) {
    Watched watched(std::nullopt);
    watched.go_on(10, 0.5e6);
    ASSERT_GT(watched.rate.coarser(), 10);
    watched.rate.pause();
    watched.rate.delivered(watched.now_s + 60, 2, {0, 0});
    EXPECT_EQ(watched.rate.coarser(), 0);
}

/// A viewer that changes from one radio cell to the next is not a viewer with a bad line.
TEST(RateControl, ForgivesALineThatStandsStillForAMoment) {
    Watched watched(std::nullopt);
    watched.go_on(10, 20e6);
    watched.go_on(1.6, 0);
    EXPECT_LT(watched.rate.coarser(), 3);
    watched.go_on(3, 20e6);
    EXPECT_EQ(watched.rate.coarser(), 0);
}

/// The first look after that finds little of a whole second.
TEST(RateControl, ForgivesALineThatComesBackBetweenTwoLooks) {
    Watched watched(std::nullopt);
    watched.go_on(10, 20e6);
    watched.go_on(1.6, 0);
    watched.go_on(sphere_s, 0.02 * 20e6);
    watched.go_on(3, 20e6);
    EXPECT_LT(watched.rate.coarser(), 3);
}

TEST(RateControl, TakesFromTheWindowFirstAndFromTheSphereLast) {
    EXPECT_EQ(divided(6, true).window, 6);
    EXPECT_EQ(divided(6, true).base, 0);
    EXPECT_EQ(divided(18, true).window, 18);
    EXPECT_EQ(divided(18, true).base, 6);
    EXPECT_EQ(divided(18, false).base, 18);
}

TEST(WindowHalvings, BeginWhereTheWindowsCrfIsHigh) {
    EXPECT_EQ(WindowHalvings(16).next(0, 18), 0) << "CRF 34";
    EXPECT_EQ(WindowHalvings(16).next(0, 18.5), 1);
    EXPECT_EQ(WindowHalvings(16).next(0, 24.5), 2) << "at once";
    EXPECT_EQ(WindowHalvings(10).next(0, 40), 2) << "no further";
}

TEST(WindowHalvings, TakeNoPixelsBeforeCrfIsCoarserThanAskedFor) {
    EXPECT_EQ(WindowHalvings(40).next(0, 0), 0);
    EXPECT_EQ(WindowHalvings(40).next(0, 8), 0);
    EXPECT_EQ(WindowHalvings(40).next(0, 9), 1) << "CRF 49 where 40 is asked for";
}

TEST(WindowHalvings, GiveBackOneAtATimeAfterTenSeconds) {
    WindowHalvings halvings(16);
    EXPECT_EQ(halvings.next(0, 30), 2);
    EXPECT_EQ(halvings.next(1, 21), 2) << "CRF 31 with half the pixels";
    EXPECT_EQ(halvings.next(20, 21), 2);
    EXPECT_EQ(halvings.next(21, 0), 2);
    EXPECT_EQ(halvings.next(30.9, 0), 2);
    EXPECT_EQ(halvings.next(31, 0), 1);
    EXPECT_EQ(halvings.next(32, 0), 1);
    EXPECT_EQ(halvings.next(40, 16), 1) << "begins anew";
    EXPECT_EQ(halvings.next(49, 0), 1);
    EXPECT_EQ(halvings.next(58, 0), 1);
    EXPECT_EQ(halvings.next(59, 0), 0);
}

/// A change of size begins a group, whose key frame makes the stream coarser for a while.
TEST(WindowHalvings, DoNotFlutterOnASteadyLine) {
    for (const double key_frame_takes : {8.0, 20.0})
        for (double line_bps = 2e5; line_bps < 2e6; line_bps *= 1.1) {
            RateControl rate(line_bps);
            WindowHalvings halvings(16);
            int now = 0, changes = 0;
            for (double at_s = 0; at_s < 90; at_s += 0.35) {
                const int before = std::exchange(now, halvings.next(at_s, rate.coarser()));
                changes += at_s > 20 && now != before;
                const double bits = 1e6 * (now != before ? key_frame_takes : 1) * std::exp2(-rate.coarser() / 6);
                rate.coded(at_s, std::size_t(bits / 8), rate.coarser(), now != before);
            }
            EXPECT_LE(changes, 1) << line_bps << ", " << key_frame_takes;
        }
}

/// After a restart of the renderer the same viewers stay.
TEST(RateControl, WhatWasSentBeforeAPauseSaysNothingOfTheLine) {
    Watched watched(std::nullopt);
    watched.go_on(10, 1e6);
    const double before = watched.rate.coarser();
    ASSERT_GT(before, 10);
    watched.now_s += 60;
    watched.rate.pause();
    watched.go_on(1, 1e6);
    EXPECT_LT(watched.rate.coarser(), before + 6);
}

}  // namespace
}  // namespace equistream::serve
