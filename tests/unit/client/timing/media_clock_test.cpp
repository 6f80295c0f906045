#include <client/timing/media_clock.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <vector>

namespace equistream::test {
namespace {

constexpr double interval_s = 1.0 / 30;

struct Arrival {
    double frame_time_s, arrival_s;
};

struct Shown {
    double display_s;
    MediaTime time;
    double newest_s;  ///< frame that had come
};

/// At 90 Hz unless told; arrivals in the order of their arrival.
std::vector<Shown> watch(MediaClock& clock, std::vector<Arrival> arrivals, double until_s, double hz = 90) {
    std::ranges::stable_sort(arrivals, {}, &Arrival::arrival_s);
    std::vector<Shown> shown;
    auto next = arrivals.begin();
    double newest_s = -1e9;
    for (std::int64_t k = 0; double(k) / hz < until_s; ++k) {
        const double display_s = double(k) / hz;
        for (; next != arrivals.end() && next->arrival_s <= display_s; ++next) {
            clock.arrived(next->frame_time_s, next->arrival_s);
            newest_s = std::max(newest_s, next->frame_time_s);
        }
        if (const auto time = clock.at(display_s))
            shown.push_back({display_s, *time, newest_s});
    }
    return shown;
}

template <typename Delay>
std::vector<Arrival> frames(double from_s, double to_s, const Delay& delay_s, double every_s = interval_s) {
    std::vector<Arrival> arrivals;
    for (std::int64_t i = std::llround(from_s / every_s); double(i) * every_s < to_s - 1e-9; ++i)
        arrivals.push_back({double(i) * every_s, double(i) * every_s + delay_s(double(i) * every_s)});
    return arrivals;
}

void expect_calm(const std::vector<Shown>& shown, const MediaClockOptions& options) {
    for (std::size_t i = 1; i < shown.size(); ++i) {
        const double elapsed_s = shown[i].display_s - shown[i - 1].display_s;
        const double rate = (shown[i].time.frame_time_s - shown[i - 1].time.frame_time_s) / elapsed_s;
        const double before = shown[i - 1].time.rate;
        ASSERT_GE(rate, 0) << shown[i].display_s;
        ASSERT_LE(rate, options.max_rate + 1e-9) << shown[i].display_s;
        ASSERT_NEAR(rate, shown[i].time.rate, 1e-6) << shown[i].display_s;
        ASSERT_LE(rate, before + options.max_rate_rise_per_s * elapsed_s + 1e-9) << shown[i].display_s;
    }
}

const Shown& at(const std::vector<Shown>& shown, double display_s) {
    return *std::ranges::find_if(shown, [&](const Shown& s) { return s.display_s >= display_s - 1e-9; });
}

TEST(MediaClock, NothingBeforeTheFirstFrame) {
    MediaClock clock;
    EXPECT_FALSE(clock.at(0));
    clock.arrived(7, 0.5);
    const auto time = clock.at(0.5);
    ASSERT_TRUE(time);
    EXPECT_EQ(time->frame_time_s, 7);
    EXPECT_EQ(time->state, ClockState::starting);
}

TEST(MediaClock, ConstantDelayIsDisplayTimeLessAConstant) {
    for (const double hz : {24.0, 72.0, 90.0, 144.0}) {
        MediaClock clock;
        const auto shown = watch(clock, frames(0, 12, [](double) { return 0.08; }), 12, hz);
        expect_calm(shown, {});
        EXPECT_NEAR(clock.playout_delay_s(), MediaClockOptions{}.min_delay_s, 1e-12);
        EXPECT_NEAR(clock.frame_interval_s(), interval_s, 1e-12);
        for (const Shown& s : shown) {
            const double aim_s = s.display_s - 0.08 - MediaClockOptions{}.min_delay_s;
            if (s.display_s > 8) {
                EXPECT_NEAR(s.time.frame_time_s, aim_s, 1e-5);
                EXPECT_NEAR(s.time.rate, 1, 1e-4);
            }
            if (s.time.state != ClockState::starting) {
                EXPECT_EQ(s.time.state, ClockState::playing) << s.display_s;
            }
        }
    }
}

TEST(MediaClock, StartsGentlyFromTheFirstFrame) {
    MediaClock clock;
    const auto shown = watch(clock, frames(3, 10, [](double) { return 0.5; }), 8);
    EXPECT_NEAR(shown.front().display_s, 3.5, 1.0 / 90);
    EXPECT_EQ(shown.front().time.frame_time_s, 3);
    for (const Shown& s : shown)
        if (s.time.state == ClockState::starting) {
            EXPECT_EQ(s.time.frame_time_s, 3);
        }
    EXPECT_EQ(at(shown, 3.55).time.state, ClockState::starting);
    EXPECT_EQ(at(shown, 3.65).time.state, ClockState::playing);
    expect_calm(shown, {});
}

/// Frames 0 to 60 ms late at random: the wanted share is there when it is its turn, at a delay that is no longer than
/// it takes; frame time runs within a few per cent of display time.
TEST(MediaClock, BoundedJitterIsTakenUpByASmallDelay) {
    for (const double share : {0.5, 0.95}) {
        MediaClockOptions options;
        options.on_time_share = share;
        MediaClock clock(options);
        std::mt19937 random(3);
        std::vector<Arrival> arrivals =
            frames(0, 60, [&](double) { return 0.05 + 0.06 * double(random() >> 8) / double(1 << 24); });
        const auto shown = watch(clock, arrivals, 60);
        expect_calm(shown, {});
        EXPECT_NEAR(clock.playout_delay_s(), share * 0.06, 0.005) << share;
        double slowest = 1, fastest = 1;
        std::int64_t playing = 0, all = 0, in_time = 0, frames_seen = 0;
        for (const Shown& s : shown)
            if (s.display_s > 5) {
                slowest = std::min(slowest, s.time.rate);
                fastest = std::max(fastest, s.time.rate);
                playing += s.time.state == ClockState::playing;
                ++all;
            }
        for (const Arrival& a : arrivals)
            if (a.arrival_s > 5 && a.arrival_s < 59) {
                in_time += at(shown, a.arrival_s).time.frame_time_s <= a.frame_time_s + 1.0 / 90;
                ++frames_seen;
            }
        EXPECT_GT(slowest, 0.97) << share;
        EXPECT_LT(fastest, 1.03) << share;
        EXPECT_GT(double(playing) / double(all), share) << share;
        EXPECT_GT(double(in_time) / double(frames_seen), share - 0.02) << share;
    }
}

/// Nothing comes from 4 s to 7 s; then all that was sent meanwhile at once, as through TCP.
std::vector<Arrival> dammed_up() {
    std::vector<Arrival> arrivals = frames(0, 14, [](double) { return 0.05; });
    for (Arrival& a : arrivals)
        if (a.arrival_s > 4 && a.arrival_s < 7)
            a.arrival_s = 7;
    return arrivals;
}

TEST(MediaClock, AStallEasesToAHalt) {
    const MediaClockOptions options;
    MediaClock clock(options);
    const auto shown = watch(clock, dammed_up(), 14);
    expect_calm(shown, options);
    // Level until `overrun_s` is all the room there is, which is when the next frame is due; exponential from there.
    const double last_s = at(shown, 5).newest_s, due_s = last_s + interval_s;
    const double display_due_s = due_s + 0.05 + options.min_delay_s;
    for (const Shown& s : shown) {
        if (s.display_s < 3.5 || s.display_s >= 7)
            continue;
        const double beyond_s = s.display_s - display_due_s;
        const double expected_s =
            beyond_s <= 0 ? due_s + beyond_s : due_s + options.overrun_s * -std::expm1(-beyond_s / options.overrun_s);
        EXPECT_NEAR(s.time.frame_time_s, expected_s, 2e-3) << s.display_s;
    }
    EXPECT_EQ(at(shown, 3.9).time.state, ClockState::playing);
    EXPECT_EQ(at(shown, 4.3).time.state, ClockState::late);
    EXPECT_EQ(at(shown, 6).time.state, ClockState::stalled);
    EXPECT_LT(at(shown, 6.9).time.rate, 1e-3);
}

TEST(MediaClock, AfterAStallItCatchesUpWithoutAJump) {
    MediaClock clock;
    const auto shown = watch(clock, dammed_up(), 14);
    EXPECT_EQ(at(shown, 7.1).time.state, ClockState::catching_up);
    double fastest = 0, until_s = 0;
    for (const Shown& s : shown) {
        fastest = std::max(fastest, s.time.rate);
        if (s.time.state == ClockState::catching_up)
            until_s = s.display_s;
    }
    EXPECT_GT(fastest, 2);
    EXPECT_LT(until_s, 10);
    const Shown& end = at(shown, 13.9);
    EXPECT_NEAR(end.time.frame_time_s, end.display_s - 0.05 - clock.playout_delay_s(), 0.01);
    EXPECT_NEAR(end.time.rate, 1, 0.02);
    EXPECT_EQ(end.time.state, ClockState::playing);
    EXPECT_EQ(clock.cuts(), 0);
}

/// The server itself stood still: the frame after is the next one, 3 s late, and so are all from then on. Live spheres
/// may be few: what was known before is forgotten by time, not by number.
TEST(MediaClock, AServerThatStoodStillIsFollowedAtItsNewDelay) {
    for (const double every_s : {interval_s, 0.2}) {
        MediaClock clock;
        const auto shown = watch(clock,
                                 frames(
                                     0, 17, [](double t) { return t < 3.99 ? 0.05 : 3.05; }, every_s),
                                 20);
        expect_calm(shown, {});
        for (const Shown& s : shown)
            if (s.display_s > 8) {
                EXPECT_GT(s.time.rate, 0.5) << s.display_s;
            }
        const Shown& end = at(shown, 19.9);
        EXPECT_NEAR(end.time.frame_time_s, end.display_s - 3.05 - clock.playout_delay_s(), 1e-3);
        EXPECT_EQ(end.time.state, ClockState::playing);
    }
}

TEST(MediaClock, FurtherBehindThanWorthFollowingIsACut) {
    MediaClock clock;
    std::vector<Arrival> arrivals = frames(0, 30, [](double) { return 0.05; });
    std::erase_if(arrivals, [](const Arrival& a) { return a.arrival_s > 4 && a.arrival_s < 16; });
    const auto shown = watch(clock, arrivals, 20);
    EXPECT_EQ(clock.cuts(), 1);
    EXPECT_NEAR(at(shown, 16.2).time.frame_time_s, 16.1, 0.1);
    for (std::size_t i = 1; i < shown.size(); ++i)
        EXPECT_GE(shown[i].time.frame_time_s, shown[i - 1].time.frame_time_s);
}

TEST(MediaClock, AWindowThatWasHiddenComesBackWhereTheStreamIs) {
    MediaClock clock;
    const auto shown = watch(clock, frames(0, 4, [](double) { return 0.05; }), 4);
    for (const Arrival& a : frames(4, 7, [](double) { return 0.05; }))
        clock.arrived(a.frame_time_s, a.arrival_s);
    const auto back = clock.at(7);
    EXPECT_NEAR(back->frame_time_s, 7 - 0.05 - clock.playout_delay_s(), 1e-6);
    EXPECT_EQ(clock.cuts(), 1);
    EXPECT_EQ(shown.back().time.state, ClockState::playing);

    MediaClock extrapolated;  // hidden while things were extrapolated beyond the last frame
    const auto before = watch(extrapolated, frames(0, 4, [](double) { return 0.05; }), 5);
    EXPECT_GT(before.back().time.frame_time_s, 4);
    EXPECT_EQ(extrapolated.at(8)->frame_time_s, before.back().time.frame_time_s);
    EXPECT_EQ(extrapolated.cuts(), 0);
}

TEST(MediaClock, AStallLeavesThePlayoutDelayAsItWas) {
    MediaClock clock;
    const auto shown = watch(clock, dammed_up(), 9);
    EXPECT_NEAR(clock.playout_delay_s(), MediaClockOptions{}.min_delay_s, 1e-9);
    MediaClock fresh;  // and one that has seen nothing else
    for (std::int64_t i = 0; i < 40; ++i)
        fresh.arrived(double(i) * interval_s, 5 + 1e-4 * double(i));
    const auto time = fresh.at(5.1);
    ASSERT_TRUE(time);
    EXPECT_TRUE(std::isfinite(time->frame_time_s));
    EXPECT_NEAR(fresh.playout_delay_s(), MediaClockOptions{}.min_delay_s, 1e-9);
}

TEST(MediaClock, EndsOnTheLastFrame) {
    MediaClock clock;
    auto shown = watch(clock, frames(0, 2, [](double) { return 0.05; }), 2.03);
    clock.end();
    double display_s = 2.03;
    std::optional<MediaTime> time;
    do {
        time = clock.at(display_s += 1.0 / 90);
        ASSERT_GE(time->frame_time_s, shown.back().time.frame_time_s);
        ASSERT_LE(time->frame_time_s, 59 * interval_s + 1e-9);
    } while (time->state != ClockState::ended && display_s < 10);
    EXPECT_NEAR(time->frame_time_s, 59 * interval_s, 1e-9);
    EXPECT_LT(display_s, 2.1);
}

}  // namespace
}  // namespace equistream::test
