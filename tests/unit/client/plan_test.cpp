#include "programs/play/plan.h"

#include <gtest/gtest.h>

#include <map>

namespace equistream::play {
namespace {

const PlanInputs everything{.geometry = true, .streamed_depth = true, .poses = true, .fill = "patches,small,pushpull"};

/// Rays cost 20 ms for the source and 10 for the eyes, engines and rungs what a plain count of passes gives.
double cost_ms(const Plan& plan) {
    const std::map<std::string, double> methods{{"surface", 6}, {"mesh", 9}, {"splat", 14}, {"lean", 3}, {"sphere", 2}};
    double ms = methods.at(plan.method) * (plan.method == "mesh" && plan.mesh_share == 1 ? 0.7 : 1);
    ms += plan.depth == "ray" ? 20 : 0;
    ms += plan.method == "surface" ? 10 : 0;
    ms += plan.fill == "none" ? 0 : plan.fill == "pushpull" ? 2 : 8;
    return ms;
}

TEST(Plans, StartWithTheBestAndEndWithRotation) {
    const std::vector<Plan> plans = plans_by_accuracy(everything);
    EXPECT_EQ(plans.front().method, "surface");
    EXPECT_EQ(plans.front().depth, "ray");
    EXPECT_EQ(plans.front().fill, everything.fill);
    EXPECT_EQ(plans.back().method, "sphere");
    for (const Plan& plan : plans_by_accuracy({.streamed_depth = true, .fill = "pushpull"})) {
        EXPECT_NE(plan.method, "surface");  // nobody has the eyes' depth
        EXPECT_NE(plan.depth, "ray");
    }
    for (const Plan& plan : plans_by_accuracy({.fill = "pushpull"}))
        EXPECT_EQ(plan.depth, "none");
    const std::vector<Plan> foreign = plans_by_accuracy({.geometry = true, .poses = false, .fill = "pushpull"});
    ASSERT_EQ(foreign.size(), 1u);
    EXPECT_EQ(foreign[0].method, "sphere");
}

TEST(Plans, TheMostAccurateThatFitsIsTaken) {
    const std::vector<Plan> plans = plans_by_accuracy(everything);
    std::string last;
    for (const double budget_ms : {1000.0, 40.0, 30.0, 15.0, 8.5, 3.0, 2.0}) {
        const Choice choice = choose_plan(plans, budget_ms, cost_ms);
        ASSERT_TRUE(choice.fits) << budget_ms;
        const TriedPlan& taken = choice.tried[choice.chosen];
        EXPECT_LE(taken.milliseconds, budget_ms);
        for (std::size_t i = 0; i < choice.chosen; ++i)
            EXPECT_GT(choice.tried[i].milliseconds, budget_ms);
        EXPECT_NE(choice.line(), last);
        last = choice.line();
    }
    EXPECT_EQ(choose_plan(plans, 1000, cost_ms).tried.size(), 1u);  // no more is tried than needed
}

TEST(Plans, WhereNothingFitsTheFastestIsTaken) {
    const Choice choice = choose_plan(plans_by_accuracy(everything), 0.5, cost_ms);
    EXPECT_FALSE(choice.fits);
    EXPECT_EQ(choice.tried[choice.chosen].plan.method, "sphere");
    EXPECT_NE(choice.line().find("nothing fits"), std::string::npos);
}

}  // namespace
}  // namespace equistream::play
