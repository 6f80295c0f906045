/// `play --method auto` while playing: when another plan is taken, and that it does not flap.
#include "fake_times.h"

#include <programs/play/rechoose.h>

#include <gtest/gtest.h>

#include <functional>
#include <tuple>

namespace equistream::play {
namespace {

using fakes::FakeMachine;

const RechooseOptions options;

/// Plays frames on a machine that is as fast as `load` says at each of them.
class Playing {
public:
    Playing(double budget_ms, unsigned seed = 5, const std::function<void(FakeMachine&)>& set_up = {})
        : plans_(plans_by_accuracy({.geometry = true, .streamed_depth = true, .fill = "hidden,earlier,pushpull"})),
          machine_(seed), random_(seed) {
        machine_.set("reproject mesh", 10, 4);
        machine_.set("track hidden", 0);  // counted with the frame, once it is settled that it is decoded
        if (set_up)
            set_up(machine_);
        const Measure measure = [&](const Plan& plan) { return Trial{machine_.times(plan)}; };
        choice_ = choose_plan(plans_, budget_ms, measure);
        survey(plans_, measure, choice_);
        rechooser_.emplace(plans_, choice_);
        plan_ = choice_.plan();
    }

    using Load = std::function<double(std::int64_t frame, const Plan& plan)>;
    void play(std::int64_t frames, const Load& load) {
        for (std::int64_t end = frame_ + frames; frame_ < end; ++frame_) {
            PartTimes times = machine_.times(plan_);
            const double jitter = 0.95 + double(random_() % 100) / 1000;
            for (auto& [part, ms] : times)
                ms *= load(frame_, plan_) * jitter;
            last_ms_ = total_ms(times);
            if (const auto change = rechooser_->played(times, frame_ + 1)) {
                EXPECT_EQ(change->from, plan_);
                EXPECT_NE(change->to, plan_);
                EXPECT_EQ(change->frame, frame_ + 1);
                EXPECT_EQ(change->is_up, rank(change->to) < rank(change->from));
                plan_ = change->to;
                changes_.push_back(*change);
            }
        }
    }

    std::size_t rank(const Plan& plan) const { return std::size_t(std::ranges::find(plans_, plan) - plans_.begin()); }
    const Plan& plan() const { return plan_; }
    FakeMachine& machine() { return machine_; }
    const Choice& choice() const { return choice_; }
    double milliseconds() { return machine_.milliseconds(plan_); }
    bool has_cheaper() {
        return std::ranges::any_of(
            plans_.begin() + std::ptrdiff_t(rank(plan_)) + 1, plans_.end(),
            [&](const Plan& plan) { return machine_.milliseconds(plan) < 0.7 * milliseconds(); });
    }
    const std::vector<Change>& changes() const { return changes_; }
    double last_ms() const { return last_ms_; }

private:
    std::vector<Plan> plans_;
    FakeMachine machine_;
    std::mt19937 random_;
    Choice choice_;
    std::optional<Rechooser> rechooser_;
    Plan plan_;
    std::vector<Change> changes_;
    std::int64_t frame_ = 0;
    double last_ms_ = 0;
};

double even(std::int64_t, const Plan&) {
    return 1;
}

TEST(Rechoosing, LeavesAloneWhatKeepsToItsTime) {
    for (const double budget_ms : {40, 80, 120, 200, 300}) {
        Playing playing(budget_ms);
        if (!playing.choice().fits)
            continue;
        playing.play(5000, even);
        EXPECT_TRUE(playing.changes().empty()) << budget_ms << ": " << playing.changes().front().line();
        // Fewer slow frames than half of a window are nothing to run from.
        playing.play(
            5000, [](std::int64_t frame, const Plan&) { return frame % std::int64_t(options.window) < 7 ? 3.0 : 1; });
        EXPECT_TRUE(playing.changes().empty()) << budget_ms;
    }
}

TEST(Rechoosing, StepsDownWhileTheMachineIsSlowAndBackUpAfterwards) {
    int played = 0;
    for (unsigned seed = 0; seed < 40; ++seed) {
        SCOPED_TRACE(seed);
        Playing playing(150, seed);
        if (!playing.choice().fits || !playing.has_cheaper())
            continue;
        ++played;
        // Room enough to come back to: the same plan at 0.7 of the budget.
        const double calm = 0.7 * 150 / playing.milliseconds(), busy = 1.8 * calm;
        playing.play(300, [&](std::int64_t, const Plan&) { return calm; });
        const std::size_t before = playing.changes().size();
        const Plan at_rest = playing.plan();
        playing.play(1000, [&](std::int64_t, const Plan&) { return busy; });
        ASSERT_GT(playing.changes().size(), before);
        const Change& down = playing.changes()[before];
        EXPECT_FALSE(down.is_up);
        EXPECT_EQ(down.from, at_rest);
        EXPECT_GE(down.frame, 300 + std::int64_t(options.window) / 2);
        EXPECT_LE(down.frame, 300 + std::int64_t(options.window));
        EXPECT_GT(down.median_ms, options.over * 150);
        EXPECT_LE(playing.changes().size(), before + 3);
        const std::size_t rank = playing.rank(playing.plan());
        playing.play(1000, [&](std::int64_t, const Plan&) { return calm; });
        EXPECT_TRUE(playing.changes().back().is_up);
        EXPECT_LT(playing.rank(playing.plan()), rank);
        EXPECT_LE(playing.rank(playing.plan()), playing.rank(at_rest));
        EXPECT_LE(playing.last_ms(), options.over * 150);
        EXPECT_NE(playing.changes().back().line().find("up to " + playing.plan().words()), std::string::npos);
    }
    EXPECT_GE(played, 20);
}

TEST(Rechoosing, StaysWhereNothingIsCheaper) {
    Playing playing(0.01);
    ASSERT_FALSE(playing.choice().fits);
    playing.play(2000, even);
    EXPECT_TRUE(playing.changes().empty());
}

/// Depth and gaps cost nothing where the pictures were taken from; as the head leaves, they do, and nothing else
/// changes.
TEST(Rechoosing, TakesWhatFitsWhereOnlyDepthAndFillGrow) {
    const auto set = [](FakeMachine& machine, double scale) {
        for (const auto& [method, reproject_ms, depth_ms] : {std::tuple{"eye-depth", 5.0, 50.0},
                                                             {"mesh", 8.0, 25.0},
                                                             {"splat", 8.0, 25.0},
                                                             {"proxy-sphere", 4.0, 0.0}}) {
            machine.set("reproject " + std::string(method), reproject_ms);
            for (const std::string depth : {"ray", "stream"})
                machine.set("depth " + depth + " for " + method, scale * depth_ms);
            for (const std::string rung : {"hidden", "earlier", "pushpull"})
                machine.set("fill " + rung + " after " + method, scale * 5);
        }
        for (const char* part : {"frame", "reproject sphere", "reliability"})
            machine.set(part, 0.5);
    };
    constexpr double budget_ms = 52;
    Playing playing(budget_ms, 5, [&](FakeMachine& machine) { set(machine, 1e-3); });
    ASSERT_EQ(playing.plan().method, "eye-depth");
    playing.play(100, even);
    ASSERT_TRUE(playing.changes().empty());
    set(playing.machine(), 1);
    playing.play(50, even);
    ASSERT_EQ(playing.changes().size(), 1u);
    EXPECT_EQ(playing.plan().method, "mesh");
    EXPECT_EQ(playing.plan().fill, "hidden,earlier,pushpull");
    EXPECT_LE(playing.milliseconds(), budget_ms);
}

/// A plan that is slow only while it is played: estimates never tell.
TEST(Rechoosing, TriesEverMoreRarelyWhatDisappoints) {
    Playing playing(150);
    ASSERT_TRUE(playing.choice().fits);
    const Plan deceptive = playing.plan();
    const double calm = 0.6 * 150 / playing.milliseconds();
    constexpr std::int64_t frames = 100000;
    playing.play(frames, [&](std::int64_t, const Plan& plan) {
        return playing.rank(plan) <= playing.rank(deceptive) ? 2 * calm : calm;
    });
    const auto& changes = playing.changes();
    ASSERT_GE(changes.size(), 4u);
    EXPECT_LE(std::int64_t(changes.size()), 2 * (7 + frames / options.longest_patience) + 2);
    std::int64_t last = 0, longest = 0;
    for (const Change& change : changes) {
        EXPECT_GE(change.frame - last, std::int64_t(options.window));
        if (change.is_up) {
            EXPECT_GE(change.frame - last, std::min(2 * longest, options.longest_patience) * (longest > 0))
                << change.line();
            longest = std::max(longest, change.frame - last);
        }
        last = change.frame;
    }
    EXPECT_GE(longest, options.longest_patience);
}

/// Around the budget, where a rule without margins would change at every turn.
TEST(Rechoosing, DoesNotFlapAtTheEdge) {
    for (const std::int64_t period : {7, 20, 50, 200, 1000})
        for (const double depth : {0.05, 0.2, 0.5}) {
            Playing playing(150);
            ASSERT_TRUE(playing.choice().fits);
            const double level = 150 / playing.milliseconds();
            playing.play(20000, [&](std::int64_t frame, const Plan&) {
                return level * (1 + depth * std::sin(6.2832 * double(frame) / double(period)));
            });
            EXPECT_LE(playing.changes().size(), 30u) << period << " " << depth;
            if (period <= 10 && depth < 0.1) {
                EXPECT_TRUE(playing.changes().empty());
            }
        }
}

}  // namespace
}  // namespace equistream::play
