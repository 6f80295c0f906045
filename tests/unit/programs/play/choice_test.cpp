/// `play --method auto` on machines without a clock: which plan is taken at the start and while playing.
#include <programs/play/choice.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>

namespace equistream::play {
namespace {

const RechooseOptions options;

std::vector<Plan> streamed_plans() {
    return plans_by_accuracy({.streamed_depth = true, .fill = "hidden,earlier,pushpull"});
}

/// A method takes its time, and fills some more for each pass.
class Machine {
public:
    explicit Machine(std::map<std::string, double> unfilled_ms, double pass_ms = 5)
        : unfilled_ms_(std::move(unfilled_ms)), pass_ms_(pass_ms) {}
    explicit Machine(std::mt19937& random) {
        const auto some_ms = [&] { return 1 + double(random() % 1000) / 10; };
        for (const char* method : {"mesh", "splat", "proxy-sphere", "rotation"})
            unfilled_ms_[method] = some_ms();
        pass_ms_ = some_ms() / 4;
    }

    FrameTimes times(const Plan& plan) const {
        const double passes = plan.fill == "none" ? 0 : 1 + double(std::ranges::count(plan.fill, ','));
        const double unfilled_ms = unfilled_ms_.at(plan.method);
        return {unfilled_ms + passes * pass_ms_, unfilled_ms};
    }
    double milliseconds(const Plan& plan) const { return times(plan).all; }
    Choice choose(const std::vector<Plan>& plans, double budget_ms) const {
        return choose_plan(plans, budget_ms, [&](const Plan& plan) { return Trial{times(plan)}; });
    }

private:
    std::map<std::string, double> unfilled_ms_;
    double pass_ms_ = 0;
};

const Machine usual({{"mesh", 60}, {"splat", 30}, {"proxy-sphere", 9}, {"rotation", 3}});

TEST(Choices, TakeTheMostAccurateThatFitsElseTheFastestTried) {
    std::mt19937 random(11);
    const std::vector<Plan> plans = streamed_plans();
    int fitting = 0, without = 0, passed = 0;
    for (int i = 0; i < 400; ++i) {
        const Machine machine(random);
        const double budget_ms = 1 + double(random() % 900) / 10;
        const Choice choice = machine.choose(plans, budget_ms);
        const auto first =
            std::ranges::find_if(plans, [&](const Plan& plan) { return machine.milliseconds(plan) <= budget_ms; });
        ASSERT_EQ(choice.fits, first != plans.end()) << choice.line();
        if (choice.fits) {
            EXPECT_EQ(choice.plan(), *first) << choice.line();
        }
        for (const TriedPlan& tried : choice.tried) {
            EXPECT_TRUE(choice.fits || tried.trial.milliseconds.all >= machine.milliseconds(choice.plan()));
        }
        for (const PassedPlan& plan : choice.passed_over) {
            EXPECT_GT(plan.at_least_ms, budget_ms);
            EXPECT_LE(plan.at_least_ms, machine.milliseconds(plan.plan));
        }
        fitting += choice.fits;
        without += !choice.fits;
        passed += !choice.passed_over.empty();
    }
    EXPECT_GT(std::min({fitting, without, passed}), 20);
}

TEST(Choices, SayWhatWasChosenAndWhy) {
    const std::vector<Plan> plans = streamed_plans();
    EXPECT_EQ(usual.choose(plans, 80).line(),
              "mesh, depth stream, fill hidden,earlier,pushpull: 75.0 ms of 80.0 (the most accurate there is; 1 tried, "
              "0 passed over)");
    EXPECT_EQ(usual.choose(plans, 41).line(),
              "splat, depth stream, fill hidden,pushpull: 40.0 ms of 41.0 (next better: splat, depth stream, fill "
              "hidden,earlier,pushpull, 45.0 ms tried; 3 tried, 0 passed over)");
    EXPECT_EQ(usual.choose(plans, 20).line(),
              "proxy-sphere, depth none, fill pushpull: 14.0 ms of 20.0 (next better: splat, depth stream, fill "
              "pushpull, at least 30.0 ms; 3 tried, 2 passed over)");
    EXPECT_EQ(usual.choose(plans, 0.5).line(),
              "rotation, depth none, fill none: 3.0 ms of 0.5 (nothing fits; this is the fastest tried; 5 tried, 2 "
              "passed over)");
}

/// Plays frames on a machine that is as much slower as `load` says at each of them.
class Playing {
public:
    explicit Playing(double budget_ms, const Machine& machine = usual)
        : plans_(streamed_plans()), machine_(machine), plan_(machine_.choose(plans_, budget_ms).plan()),
          rechooser_(plans_, machine_.choose(plans_, budget_ms)) {}

    using Load = std::function<double(std::int64_t frame, const Plan& plan)>;
    void play(std::int64_t frames, const Load& load) {
        for (const std::int64_t end = frame_ + frames; frame_ < end;) {
            const double slower = load(frame_, plan_) * (0.95 + double(random_() % 100) / 1000);
            const auto [all_ms, unfilled_ms] = machine_.times(plan_);
            const auto change = rechooser_.played({slower * all_ms, slower * unfilled_ms}, ++frame_);
            if (!change)
                continue;
            EXPECT_EQ(change->from, plan_);
            EXPECT_EQ(change->frame, frame_);
            EXPECT_EQ(change->is_up, rank(change->to) < rank(plan_));
            plan_ = change->to;
            changes_.push_back(*change);
        }
    }
    void play(std::int64_t frames, double load) {
        play(frames, [&](std::int64_t, const Plan&) { return load; });
    }

    std::ptrdiff_t rank(const Plan& plan) const { return std::ranges::find(plans_, plan) - plans_.begin(); }
    const Plan& plan() const { return plan_; }
    double milliseconds() const { return machine_.milliseconds(plan_); }
    const std::vector<Change>& changes() const { return changes_; }

private:
    std::vector<Plan> plans_;
    Machine machine_;
    std::mt19937 random_{5};
    Plan plan_;
    Rechooser rechooser_;
    std::vector<Change> changes_;
    std::int64_t frame_ = 0;
};

TEST(Rechoosing, LeavesAloneWhatKeepsToItsTime) {
    for (const double budget_ms : {3, 10, 15, 36, 46, 80}) {
        Playing playing(budget_ms);
        playing.play(5000, 1);
        // Fewer slow frames than half of a window are nothing to run from.
        playing.play(5000, [](std::int64_t frame, const Plan&) { return frame % 15 < 7 ? 3.0 : 1.0; });
        EXPECT_TRUE(playing.changes().empty()) << playing.changes().front().line();
    }
}

TEST(Rechoosing, FollowsASlowdownAndRecovers) {
    for (const double busy : {1.3, 2.0, 4.0}) {
        Playing playing(60);  // splat with all passes, 45 ms
        const Plan at_rest = playing.plan();
        playing.play(300, 1);
        playing.play(400, busy * 60 / 45);
        ASSERT_FALSE(playing.changes().empty());
        const Change down = playing.changes().front();
        EXPECT_FALSE(down.is_up);
        EXPECT_EQ(down.from, at_rest);
        EXPECT_GE(down.frame, 300 + 7);
        EXPECT_LE(down.frame, 300 + 15);
        EXPECT_GT(down.median_ms, options.over * 60);
        EXPECT_LE(busy * 60 / 45 * playing.milliseconds(), options.over * 60) << playing.plan().words();
        EXPECT_LE(playing.changes().size(), 3u) << "one change of method, and its chains";
        playing.play(1000, 1);
        EXPECT_EQ(playing.plan(), at_rest) << playing.plan().words();
    }
}

TEST(Rechoosing, SaysWhatItDid) {
    Playing playing(60);
    playing.play(60, 4);
    playing.play(200, 1);
    ASSERT_EQ(playing.changes().size(), 2u);
    const auto [down, up] = std::pair(playing.changes()[0].line(), playing.changes()[1].line());
    EXPECT_TRUE(down.starts_with("frame 15: down to proxy-sphere, depth none, fill pushpull (splat, depth stream, fill "
                                 "hidden,earlier,pushpull took 1"))
        << down;
    EXPECT_TRUE(down.ends_with(" ms of 60.0)")) << down;
    EXPECT_NE(up.find(": up to splat, depth stream, fill hidden,earlier,pushpull, 4"), std::string::npos) << up;
    EXPECT_NE(up.find(" ms expected (proxy-sphere, depth none, fill pushpull took 1"), std::string::npos) << up;
}

TEST(Rechoosing, StaysWhereNothingIsFaster) {
    Playing nothing_fits(0.01);
    nothing_fits.play(500, 1);
    EXPECT_TRUE(nothing_fits.changes().empty());
    // What was tried at the start is known to be no way out.
    Playing all_slower(20.5, Machine({{"mesh", 20}, {"splat", 60}, {"proxy-sphere", 90}, {"rotation", 80}}, 1));
    ASSERT_EQ(all_slower.plan().method, "mesh");
    all_slower.play(500, 1);
    EXPECT_TRUE(all_slower.changes().empty());
}

/// The slowdown ends right after the step down: no window says by how much.
TEST(Rechoosing, ComesBackToWhatHasFittedBefore) {
    Playing playing(60);
    const Plan at_rest = playing.plan();
    playing.play(15, 4);
    ASSERT_NE(playing.plan(), at_rest);
    playing.play(1000, 1);
    EXPECT_EQ(playing.plan(), at_rest);
    EXPECT_EQ(playing.changes().size(), 2u);
}

/// Fast when it was tried, and slow whenever it is played.
TEST(Rechoosing, TriesEverMoreRarelyWhatDisappoints) {
    constexpr std::int64_t frames = 100000;
    Playing playing(60);
    playing.play(frames, [](std::int64_t, const Plan& plan) { return plan.method == "splat" ? 2.5 : 1.0; });
    std::vector<std::int64_t> waits;
    std::int64_t last = 0;
    for (const Change& change : playing.changes()) {
        EXPECT_GE(change.frame - last, std::int64_t(options.window));
        if (change.is_up)
            waits.push_back(change.frame - last);
        last = change.frame;
    }
    ASSERT_GE(waits.size(), 6u);
    EXPECT_LE(std::int64_t(waits.size()), 4 + frames / options.longest_patience);
    for (std::size_t i = 0; i < waits.size(); ++i)
        EXPECT_GE(waits[i],
                  std::min(options.retry * options.patience << std::min<std::size_t>(i, 6), options.longest_patience));
}

/// Around the budget, where a rule without margins would change at every turn.
TEST(Rechoosing, DoesNotFlapAtTheEdge) {
    for (const std::int64_t period : {7, 20, 50, 200, 1000})
        for (const double depth : {0.05, 0.2, 0.5}) {
            Playing playing(50);
            playing.play(20000, [&](std::int64_t frame, const Plan&) {
                return 50.0 / 45 * (1 + depth * std::sin(6.2832 * double(frame) / double(period)));
            });
            EXPECT_LE(playing.changes().size(), 30u) << period << " " << depth;
            if (period <= 10 && depth < 0.1) {
                EXPECT_TRUE(playing.changes().empty());
            }
        }
}

}  // namespace
}  // namespace equistream::play
