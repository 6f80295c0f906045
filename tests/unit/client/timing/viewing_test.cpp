#include "head_motion.h"

#include <client/timing/viewing.h>
#include <equistream/error.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

constexpr double interval_s = 1.0 / 30, degree = pi / 180;

/// Turns at 60 degrees/s and walks at 1 m/s.
Pose steady_head(double time_s) {
    return {{time_s, 0, 0}, glm::angleAxis(60 * degree * time_s, glm::dvec3(0, 1, 0))};
}

/// At 30 frames/s, made for the head as it was.
std::vector<ServedFrame> served(std::int64_t count, const HeadPath& head, std::int64_t bytes = 20000,
                                std::int64_t first = 0) {
    std::vector<ServedFrame> frames;
    for (std::int64_t i = first; i < first + count; ++i)
        frames.push_back({i, double(i) * interval_s, head(double(i) * interval_s), bytes});
    return frames;
}

/// A whole run from a list of frames, in the order of their times.
Viewing simulate_viewing(const std::vector<ServedFrame>& frames, const HeadPath& head, const NetworkConditions& network,
                         const ViewingOptions& options = {}) {
    ViewingSimulation simulation(network, options, head);
    Viewing viewing;
    for (auto next = frames.begin();;) {
        while (simulation.needs_frame()) {
            if (next != frames.end())
                simulation.send(*next++, nullptr);
            else
                simulation.end();
        }
        const std::optional<ViewedRefresh> refresh = simulation.next();
        if (!refresh)
            break;
        viewing.refreshes.push_back(*refresh);
    }
    viewing.report = report_viewing(viewing.refreshes, options.refresh_hz);
    simulation.add_figures(viewing.report);
    return viewing;
}

const ViewedRefresh& at(const Viewing& viewing, double display_s) {
    return *std::ranges::find_if(viewing.refreshes,
                                 [&](const ViewedRefresh& r) { return r.display_s >= display_s - 1e-9; });
}

TEST(Viewing, ASteadyHeadOnASteadyNetworkInClosedForm) {
    for (const double delay_s : {0.0, 0.08}) {
        const ViewingOptions options;
        const Viewing viewing =
            simulate_viewing(served(300, steady_head, 20000, 30), steady_head, {.delay_s = delay_s}, options);
        ASSERT_GT(viewing.refreshes.size(), 800u);
        EXPECT_EQ(viewing.refreshes.front().number, 90);
        for (const ViewedRefresh& r : viewing.refreshes) {
            EXPECT_DOUBLE_EQ(r.display_s, double(r.number) / 90);
            EXPECT_LT(r.error_deg(), 1e-5);
            EXPECT_LT(r.error_m(), 1e-7);
            EXPECT_NEAR(glm::distance(r.true_head.position_m, steady_head(r.display_s).position_m), 0, 1e-12);
            // Frames are there once sent, delayed, and looked for; play-out waits min_delay_s more.
            if (r.display_s < 1 + delay_s + options.photon_s) {
                EXPECT_FALSE(r.frame);
                continue;
            }
            ASSERT_TRUE(r.frame);
            EXPECT_NEAR(r.unreprojected_error_deg(), 60 * r.age_s(), 1e-5);
            EXPECT_NEAR(r.unreprojected_error_m(), r.age_s(), 1e-9);
            if (r.display_s > 8 && r.display_s < 10.9) {
                const double frame_time_s = r.display_s - options.photon_s - delay_s - options.clock.min_delay_s;
                EXPECT_EQ(r.frame->number, std::int64_t(std::floor(frame_time_s * 30 + 2e-3)));
                EXPECT_EQ(r.previous->number, r.frame->number - 1);
                EXPECT_NEAR(r.extrapolated_s, frame_time_s - r.frame->frame_time_s, 1e-4);
                EXPECT_EQ(r.state, ClockState::playing);
            }
        }
        EXPECT_EQ(viewing.refreshes.back().frame->number, 329);
        EXPECT_EQ(viewing.refreshes.back().state, ClockState::ended);
        EXPECT_EQ(viewing.report.frames_shown, 300);
        EXPECT_EQ(viewing.report.frames_sent, 300);
        EXPECT_NEAR(double(viewing.report.repeated) / double(viewing.report.refreshes), 2.0 / 3, 0.02);
    }
}

/// What shows is what the network had brought by then, and the newest of that for the clock's time.
TEST(Viewing, ShowsTheNewestOfWhatHadCome) {
    for (const bool datagrams : {false, true}) {
        const HeadMotion motion(4, 10);
        const HeadPath head = [&](double t) { return motion.at(t); };
        const auto frames = served(240, head, 30000);
        const NetworkConditions network{.delay_s = 0.06,
                                        .jitter_s = 0.09,
                                        .loss = 0.01,
                                        .bandwidth_bps = 20e6,
                                        .datagrams = datagrams,
                                        .stalls = {{3, 0.2}}};
        DeliverySimulator simulator(network);
        std::vector<std::optional<double>> arrivals;
        for (const ServedFrame& frame : frames)
            arrivals.push_back(simulator.send(frame.frame_time_s, frame.bytes));
        const ViewingOptions options;
        const Viewing viewing = simulate_viewing(frames, head, network, options);
        double last_s = -1;
        for (const ViewedRefresh& r : viewing.refreshes) {
            if (!r.frame)
                continue;
            const double made_s = r.display_s - options.photon_s, time_s = r.frame->frame_time_s + r.extrapolated_s;
            EXPECT_GE(time_s, last_s - 1e-9);
            last_s = time_s;
            std::int64_t newest = -1, before = -1;
            for (std::size_t i = 0; i < frames.size(); ++i)
                if (arrivals[i] && *arrivals[i] <= made_s && frames[i].frame_time_s <= time_s + 1e-6) {
                    before = newest;
                    newest = std::int64_t(i);
                }
            EXPECT_EQ(r.frame->number, newest) << r.display_s;
            EXPECT_EQ(r.previous ? r.previous->number : -1, before) << r.display_s;
            EXPECT_EQ(r.frame->arrival_s, *arrivals[std::size_t(newest)]);
        }
        const auto lost = std::ranges::count_if(arrivals, [](const auto& arrival) { return !arrival; });
        EXPECT_EQ(viewing.report.frames_lost, lost);
        EXPECT_EQ(lost > 0, datagrams);
        std::int64_t delivered = 0;
        for (const std::int64_t n : viewing.report.deliveries.by)
            delivered += n;
        EXPECT_EQ(delivered, 240 - lost);
        EXPECT_EQ(viewing.report.deliveries[Delivery::out_of_order] + viewing.report.deliveries[Delivery::late] > 0,
                  datagrams);
    }
}

/// The point of it all: however late the server, the head is shown as if there were none.
TEST(Viewing, AStallOfSecondsTouchesFramesButNotTheHead) {
    const HeadMotion motion(2, 14);
    const HeadPath head = [&](double t) { return motion.at(t); };
    const auto frames = served(360, head);
    const ViewingOptions options;
    const Viewing calm = simulate_viewing(frames, head, {}, options);
    const Viewing stalled = simulate_viewing(frames, head, {.delay_s = 0.08, .stalls = {{4, 3}}}, options);
    std::int64_t last = -1;
    for (std::size_t i = 0; i < std::min(calm.refreshes.size(), stalled.refreshes.size()); ++i) {
        const ViewedRefresh& r = stalled.refreshes[i];
        EXPECT_EQ(r.error_deg(), calm.refreshes[i].error_deg());
        if (!r.frame)
            continue;
        EXPECT_GE(r.frame->number, last);
        last = r.frame->number;
        EXPECT_LE(r.rate, options.clock.max_rate + 1e-9);
        if (r.state != ClockState::catching_up) {
            EXPECT_LE(r.extrapolated_s, interval_s + options.clock.overrun_s + 1e-9);
        }
    }
    EXPECT_EQ(at(stalled, 6.9).frame->number, 119);
    EXPECT_EQ(at(stalled, 6.9).state, ClockState::stalled);
    EXPECT_EQ(at(stalled, 7.2).state, ClockState::catching_up);
    EXPECT_LT(at(stalled, 9.5).age_s(), 0.2);
    EXPECT_GT(at(stalled, 6.9).age_s(), 2.9);
    EXPECT_GT(stalled.report.state_s[std::size_t(ClockState::stalled)], 2);
    EXPECT_LT(stalled.report.state_s[std::size_t(ClockState::stalled)], 3);
    EXPECT_GT(stalled.report.deliveries.thinned, 0);
    EXPECT_LT(stalled.report.error_deg.p95, 0.5);
    EXPECT_GT(stalled.report.unreprojected_error_deg.p95, 30);
    EXPECT_EQ(stalled.refreshes.back().frame->number, 359);
}

TEST(Viewing, EndsWhereNothingComesAtAll) {
    const NetworkConditions network{.loss = 0.9, .datagrams = true};
    const Viewing viewing = simulate_viewing(served(90, steady_head, 1000000), steady_head, network);
    EXPECT_EQ(viewing.report.frames_lost, 90);
    EXPECT_LT(viewing.refreshes.size(), 400u);
    EXPECT_EQ(viewing.report.blank, viewing.report.refreshes);
    EXPECT_TRUE(simulate_viewing({}, steady_head, network).refreshes.empty());
}

/// Whatever the network does, frames' time goes forward at no more than its highest rate, but for counted cuts, and the
/// last that came is what is seen at the end.
TEST(Viewing, AnyNetworkIsShownCalmly) {
    std::mt19937 random(11);
    const auto uniform = [&](double low, double high) {
        return low + (high - low) * double(random()) / double(std::mt19937::max());
    };
    std::int64_t cuts = 0, lost = 0, thinned = 0;
    for (std::uint64_t run = 0; run < 120; ++run) {
        NetworkConditions network{.delay_s = uniform(0, 0.3),
                                  .jitter_s = run % 3 == 0 ? uniform(0, 1) : uniform(0, 0.1),
                                  .loss = run % 2 == 0 ? 0 : uniform(0, 0.1),
                                  .bandwidth_bps = run % 5 == 0 ? 0 : uniform(2e6, 40e6),
                                  .datagrams = run % 4 == 1,
                                  .seed = run};
        for (double t = uniform(0, 3); t < 8; t += uniform(0.5, 4))
            network.stalls.push_back({t, uniform(0, run % 7 == 0 ? 9 : 1)});
        ViewingOptions options;
        options.refresh_hz = uniform(20, 144);
        const auto frames = served(240, steady_head, std::int64_t(uniform(1000, 30000)), std::int64_t(run));
        const Viewing viewing = simulate_viewing(frames, steady_head, network, options);
        SCOPED_TRACE(run);
        std::int64_t jumps = 0, newest = -1;
        double last_s = -1;
        ASSERT_FALSE(viewing.refreshes.empty());
        for (std::size_t i = 0; i < viewing.refreshes.size(); ++i) {
            const ViewedRefresh& r = viewing.refreshes[i];
            ASSERT_EQ(r.number, viewing.refreshes.front().number + std::int64_t(i));
            if (!r.frame) {
                ASSERT_EQ(last_s, -1) << "blank again";
                continue;
            }
            ASSERT_GE(r.extrapolated_s, -1e-6);
            ASSERT_LE(r.frame->arrival_s, r.display_s - options.photon_s);
            const double time_s = r.frame->frame_time_s + r.extrapolated_s;
            if (last_s >= 0) {
                ASSERT_GE(time_s, last_s - 1e-9) << r.display_s;
                jumps += time_s - last_s > options.clock.max_rate / options.refresh_hz + 1e-9;
            }
            last_s = time_s;
            newest = std::max(newest, r.frame->number);
        }
        EXPECT_LE(jumps, viewing.report.cuts);
        if (viewing.report.frames_lost == 0) {
            EXPECT_EQ(viewing.refreshes.back().frame->number, 239 + std::int64_t(run));
        }
        EXPECT_EQ(viewing.refreshes.back().frame->number, newest);
        cuts += viewing.report.cuts;
        lost += viewing.report.frames_lost;
        thinned += viewing.report.deliveries.thinned;
    }
    EXPECT_GT(cuts, 0);
    EXPECT_GT(lost, 0);
    EXPECT_GT(thinned, 0);
}

TEST(Viewing, IsTheSameEveryTime) {
    const auto frames = served(100, steady_head);
    const NetworkConditions network{.delay_s = 0.05, .jitter_s = 0.05, .loss = 0.02, .seed = 3};
    const auto json = [&](const NetworkConditions& conditions) {
        const Viewing viewing = simulate_viewing(frames, steady_head, conditions);
        return viewing_json(viewing.report, viewing.refreshes).dump();
    };
    EXPECT_EQ(json(network), json(network));
    NetworkConditions other = network;
    other.seed = 4;
    EXPECT_NE(json(network), json(other));
}

/// Each would be shown at every refresh up to the damaged time, or counted beyond what a number holds.
TEST(Viewing, DamagedTimesAreRefused) {
    for (const double damaged_s : {1e9, 86401.0, -0.01, std::nan("")}) {
        std::vector<ServedFrame> frames = served(3, steady_head);
        frames[1].frame_time_s = damaged_s;
        EXPECT_THROW(simulate_viewing(frames, steady_head, {}), InputError) << damaged_s;
    }
    for (const double damaged_s : {1e300, -1e11}) {
        std::vector<ServedFrame> frames = served(1, steady_head);
        frames[0].frame_time_s = damaged_s;
        EXPECT_THROW(simulate_viewing(frames, steady_head, {}), InputError) << damaged_s;
    }
}

/// Every refresh until then would be shown. A trace on another clock has a line for none of the frames.
TEST(Viewing, ArrivalsFarFromTheirFramesAreRefused) {
    const std::vector<NetworkConditions> networks = {
        {.bandwidth_bps = 1}, {.trace = {{0, 1.7e9}}}, {.trace = {{0, -1.7e9}}}, {.trace = {{1.7e9, 1.7e9}}}};
    for (const NetworkConditions& network : networks) {
        ViewingSimulation simulation(network, {}, steady_head);
        EXPECT_THROW(simulation.send(served(1, steady_head)[0], nullptr), InputError)
            << network.bandwidth_bps << " bits/s, " << network.trace.size() << " arrivals";
    }
    EXPECT_EQ(simulate_viewing(served(2, steady_head), steady_head, {.trace = {{0, 0.05}}}).report.frames_lost, 1)
        << "what follows the last arrival is lost at once";
}

TEST(Viewing, EpochSecondsAndFramesOfOneTimeAreShown) {
    const double began_s = 1.7e9;
    std::vector<ServedFrame> frames = served(3, steady_head);
    for (ServedFrame& frame : frames)
        frame.frame_time_s += began_s;
    frames[1].frame_time_s = began_s;
    EXPECT_EQ(simulate_viewing(frames, steady_head, {}).report.frames_sent, 3);
}

TEST(ViewingReport, SumsUpByHand) {
    const auto refresh = [](std::int64_t number, std::int64_t frame, double off_deg, ClockState state) {
        ViewedRefresh r;
        r.number = number;
        r.display_s = double(number) / 10;
        r.true_head = {{0, 0, 0.5}, glm::angleAxis(20 * degree, glm::dvec3(0, 0, 1))};
        r.predicted_head = {{0.003, 0.004, 0.5},
                            glm::angleAxis(off_deg * degree, glm::dvec3(1, 0, 0)) * r.true_head.orientation};
        if (frame >= 0)
            r.frame = {.number = frame, .frame_time_s = double(frame) / 100};
        r.extrapolated_s = 0.01;
        r.state = state;
        return r;
    };
    const std::vector<ViewedRefresh> refreshes = {
        refresh(1, -1, 0, ClockState::starting), refresh(2, 10, 1, ClockState::playing),
        refresh(3, 10, 2, ClockState::late), refresh(4, 30, 3, ClockState::playing),
        refresh(5, 30, -10, ClockState::playing)};
    const ViewingReport report = report_viewing(refreshes, 10);
    EXPECT_EQ(report.refreshes, 5);
    EXPECT_EQ(report.blank, 1);
    EXPECT_EQ(report.repeated, 2);
    EXPECT_EQ(report.frames_shown, 2);
    EXPECT_NEAR(report.age_ms.mean, (100 + 200 + 100 + 200) / 4.0, 1e-9);
    EXPECT_NEAR(report.error_deg.mean, 4, 1e-9);
    EXPECT_NEAR(report.error_deg.median, 2, 1e-9);
    EXPECT_NEAR(report.error_deg.p95, 10, 1e-9);
    EXPECT_NEAR(report.error_deg.max, 10, 1e-9);
    EXPECT_NEAR(report.error_m.max, 0.005, 1e-12);
    EXPECT_NEAR(report.unreprojected_error_deg.median, 20, 1e-9);
    EXPECT_NEAR(report.unreprojected_error_m.mean, 0.5, 1e-12);
    EXPECT_NEAR(report.extrapolated_ms.max, 10, 1e-12);
    EXPECT_NEAR(report.state_s[std::size_t(ClockState::playing)], 0.3, 1e-12);
    EXPECT_NEAR(report.state_s[std::size_t(ClockState::late)], 0.1, 1e-12);
    const auto json = viewing_json(report, refreshes);
    EXPECT_EQ(json["each"].size(), 5u);
    EXPECT_FALSE(json["each"][0].contains("frame"));
    EXPECT_EQ(json["each"][4]["frame"], 30);
    EXPECT_EQ(json["each"][2]["state"], "late");
    EXPECT_NEAR(json["error_deg"]["p95"].get<double>(), 10, 1e-9);
    EXPECT_NEAR(json["state_s"]["playing"].get<double>(), 0.3, 1e-12);
    EXPECT_NE(report.table().find("head error, degrees"), std::string::npos);
    EXPECT_EQ(quantiles_of({}).max, 0);
    std::vector<double> many(200);
    std::iota(many.rbegin(), many.rend(), 1);
    EXPECT_EQ(quantiles_of(many).p99, 198);
}

/// Pictures are behind by photon_s and min_delay_s: 20 and 5 ms.
TEST(Viewing, WhatMovesIsCarriedOnToNowAsFarAsIsAllowed) {
    for (const double limit_s : {0.01, 0.05}) {
        ViewingOptions options;
        options.extrapolation_limit_s = limit_s;
        int looked_at = 0;
        for (const ViewedRefresh& r : simulate_viewing(served(300, steady_head), steady_head, {}, options).refreshes)
            if (r.display_s > 8 && r.display_s < 9.9) {
                EXPECT_NEAR(r.ahead_s, std::min(limit_s, 0.025), 1e-4);
                EXPECT_NEAR(r.extrapolation_s(), r.extrapolated_s + r.ahead_s, 1e-12);
                ++looked_at;
            }
        EXPECT_GT(looked_at, 50);
    }
}

}  // namespace
}  // namespace equistream::test
