/// `play --method auto`: which plan is taken, and with how few trials.
#include "fake_times.h"

#include <equistream/formatted.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace equistream::play {
namespace {

using fakes::FakeMachine;

std::size_t ways_of(const std::vector<Plan>& plans) {
    std::set<std::string> ways;
    for (const Plan& plan : plans)
        ways.insert(plan.method + plan.depth);
    return ways.size();
}

/// Costs that have nothing to do with the order, and budgets between, below and above them.
TEST(Choices, TakeTheMostAccurateThatFitsElseTheFastestWithFewTrials) {
    std::mt19937 random(11);
    const std::vector<PlanInputs> all = fakes::all_inputs();
    std::size_t plans_in_all = 0, trials_in_all = 0;
    for (unsigned i = 0; i < 600; ++i) {
        FakeMachine machine(i);
        const std::vector<Plan> plans = plans_by_accuracy(all[random() % all.size()]);
        std::vector<double> times_ms;
        for (const Plan& plan : plans)
            times_ms.push_back(machine.milliseconds(plan));
        const auto fastest = std::ranges::min_element(times_ms);
        const double budget_ms = *fastest * (0.5 + double(random() % 60) / 10);
        const Choice choice =
            choose_plan(plans, budget_ms, [&](const Plan& plan) { return Trial{machine.times(plan)}; });
        const std::string line = choice.line();
        const auto first = std::ranges::find_if(times_ms, [&](double ms) { return ms <= budget_ms; });
        ASSERT_EQ(choice.fits, first != times_ms.end()) << line;
        const auto taken = choice.fits ? first : fastest;
        ASSERT_DOUBLE_EQ(machine.milliseconds(choice.plan()), *taken) << line;
        if (choice.fits) {
            ASSERT_EQ(choice.plan(), plans[std::size_t(taken - times_ms.begin())]) << line;
        }
        EXPECT_LE(choice.tried.size(), ways_of(plans) + mesh_shares.size() + 1) << line;
        for (const TriedPlan& tried : choice.tried)
            EXPECT_LE(tried.estimate_ms, tried.trial.milliseconds() * (1 + 1e-9));
        for (const PassedPlan& passed : choice.passed_over) {
            EXPECT_GT(passed.estimate_ms, budget_ms);
            EXPECT_LE(passed.estimate_ms, machine.milliseconds(passed.plan) * (1 + 1e-9));
        }
        plans_in_all += plans.size();
        trials_in_all += choice.tried.size();
    }
    EXPECT_LT(5 * trials_in_all, plans_in_all);
}

/// What no sum of parts can know: rungs take longer where others are left out, and no two trials take the same.
TEST(Choices, RestOnATrialEvenWhereEstimatesAreWrong) {
    std::mt19937 random(12);
    const std::vector<PlanInputs> all = fakes::all_inputs();
    for (unsigned i = 0; i < 300; ++i) {
        FakeMachine machine(i);
        const std::vector<Plan> plans = plans_by_accuracy(all[random() % all.size()]);
        const double budget_ms = 5 + double(random() % 1500) / 10;
        std::set<std::string> words;
        const Choice choice = choose_plan(plans, budget_ms, [&](const Plan& plan) {
            EXPECT_TRUE(words.insert(plan.words()).second) << plan.words() << " twice";
            PartTimes times = machine.times(plan);
            for (auto& [part, ms] : times)
                ms *= 0.7 + double(random() % 60) / 100 +
                      (part.name.starts_with("fill push") ? 2.0 / double(plan.fill.size()) : 0);
            return Trial{std::move(times)};
        });
        EXPECT_EQ(words.size(), choice.tried.size());
        EXPECT_EQ(choice.fits, choice.tried[choice.chosen].trial.milliseconds() <= budget_ms);
        for (const TriedPlan& tried : choice.tried) {
            EXPECT_TRUE(choice.fits || tried.trial.milliseconds() >= choice.tried[choice.chosen].trial.milliseconds());
        }
    }
}

TEST(Choices, SayWhatWasChosenAndWhy) {
    const std::vector<Plan> plans = plans_by_accuracy({.geometry = true, .fill = "hidden,earlier,pushpull"});
    FakeMachine machine(1);
    machine.set("frame", 1);
    machine.set("track hidden", 1);
    machine.set("depth ray for eye-depth", 4);
    machine.set("reproject eye-depth", 5);
    machine.set("fill hidden after eye-depth", 8);
    machine.set("fill earlier after eye-depth", 3);
    machine.set("fill pushpull after eye-depth", 2);
    machine.set("reliability", 0);
    const auto choose = [&](double budget_ms) {
        return choose_plan(plans, budget_ms, [&](const Plan& plan) { return Trial{machine.times(plan)}; });
    };
    EXPECT_EQ(choose(30).line(),
              "eye-depth, depth ray, fill hidden,earlier,pushpull: 24.0 ms of 30.0 (the most accurate there is; "
              "1 tried, 0 passed over by estimate)");
    EXPECT_EQ(choose(22).line(),
              "eye-depth, depth ray, fill hidden,pushpull: 21.0 ms of 22.0 (next better: eye-depth, depth ray, fill "
              "hidden,earlier,pushpull, 24.0 ms tried; 2 tried, 0 passed over by estimate)");
    EXPECT_EQ(choose(15).line(),
              "eye-depth, depth ray, fill pushpull: 12.0 ms of 15.0 (next better: eye-depth, depth ray, fill "
              "hidden,pushpull, 21.0 ms estimated; 2 tried, 1 passed over by estimate)");
    EXPECT_NE(choose(0.5).line().find("(nothing fits; this is the fastest; "), std::string::npos);
}

TEST(Choices, SurveyMakesAllPlansKnownWithOneTrialOfEachMethodAndDepth) {
    // Time for the first, for some and for none: then methods may have been tried with the shortest ladder only.
    for (const double budget_ms : {1e6, 100.0, 50.0, 0.01})
        for (const PlanInputs& inputs : fakes::all_inputs()) {
            FakeMachine machine(3);
            const std::vector<Plan> plans = plans_by_accuracy(inputs);
            const Measure measure = [&](const Plan& plan) { return Trial{machine.times(plan)}; };
            Choice choice = choose_plan(plans, budget_ms, measure);
            survey(plans, measure, choice);
            std::set<std::string> ways;
            for (const TriedPlan& surveyed : choice.surveyed)
                EXPECT_TRUE(ways.insert(surveyed.plan.method + surveyed.plan.depth).second) << surveyed.plan.words();
            if (budget_ms == 1e6) {
                EXPECT_EQ(choice.tried.size() + choice.surveyed.size(), ways_of(plans));
            }
            const KnownTimes known = choice.known();
            // Enough to know all plans by, those of other densities by bounds.
            for (const Plan& plan : plans) {
                EXPECT_TRUE(std::isfinite(known.at_most_ms(plan))) << plan.words();
                EXPECT_LE(known.at_least_ms(plan), machine.milliseconds(plan) + 1e-9) << plan.words();
                EXPECT_GE(known.at_most_ms(plan), machine.milliseconds(plan) - 1e-9) << plan.words();
            }
        }
}

TEST(KnownTimes, AreBroughtUpToDateTogether) {
    KnownTimes known;
    const Plan surface{"eye-depth", 0.25, "ray", "none"}, lean{"proxy-sphere", 0.25, "none", "none"};
    known.learn({{part::frame(), 1},
                 {part::reliability(), 0},
                 {part::reproject(surface), 4},
                 {part::depth(surface), 5},
                 {part::reproject(lean), 2}});
    EXPECT_DOUBLE_EQ(known.at_most_ms(surface), 10);
    EXPECT_DOUBLE_EQ(known.at_most_ms(lean), 3);
    known.bring_up_to_date({{part::frame(), 3}, {part::reproject(surface), 6}, {part::depth(surface), 6}});
    EXPECT_DOUBLE_EQ(known.at_most_ms(surface), 15);
    // The frame came to 3 ms. Reprojection by surface went from 4 ms to 6.
    EXPECT_DOUBLE_EQ(known.at_most_ms(lean), 3 + 2 * 6.0 / 4);
    // What the frame played had no part of goes with all that it had.
    known.bring_up_to_date({{part::frame(), 3}, {part::reproject(lean), 6}});
    EXPECT_DOUBLE_EQ(known.at_most_ms(surface), 3 + 2 * (6 + 6));
}

/// As when the head leaves the place where the pictures were taken from.
TEST(KnownTimes, KeepOtherWorkWhereDepthAndGapsBeginToCost) {
    KnownTimes known;
    const Plan surface{"eye-depth", 0.25, "ray", "pushpull"}, splat{"splat", 0.25, "ray", "pushpull"},
        lean{"proxy-sphere", 0.25, "none", "none"};
    known.learn({{part::frame(), 1},
                 {part::reliability(), 0},
                 {part::reproject(surface), 4},
                 {part::depth(surface), 0.01},
                 {part::fill(surface, "pushpull"), 0.01},
                 {part::reproject(splat), 8},
                 {part::depth(splat), 0.005},
                 {part::fill(splat, "pushpull"), 0.05},
                 {part::reproject(lean), 2}});
    known.bring_up_to_date(
        {{part::reproject(surface), 4}, {part::depth(surface), 30}, {part::fill(surface, "pushpull"), 5}});
    EXPECT_DOUBLE_EQ(known.at_most_ms(lean), 1 + 2);
    // Depth as half of surface's still, and of the gaps not five times what now takes 5 ms.
    EXPECT_DOUBLE_EQ(known.at_most_ms(splat), 1 + 8 + 15 + 5);
}

}  // namespace
}  // namespace equistream::play
