#pragma once
/// Ways to play a frame, for `--method auto` (docs/guide/play.md, "Which method").
#include <equistream/stream.h>

#include <client/fill/fill.h>
#include <client/pipeline/decisions.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace equistream::play {

/// One way to play a frame.
struct Plan {
    std::string method;
    std::string depth;    ///< of is_cast, stream (what came with the frames) or none; exact only without auto
    std::string fill;     ///< as in --fill
    bool mirrors = true;  ///< Settings::asks_for_mirrors, the same for all plans of a run
    /// What the pipeline does then.
    PipelineChoice choice() const { return {method, depth, fill, mirrors}; }
    std::string words() const;  ///< "mesh, depth stream, fill pushpull"
    /// They differ by their fill chains alone.
    bool reprojects_as(const Plan& other) const { return method == other.method && depth == other.depth; }

    bool operator==(const Plan&) const = default;
};

/// What there is to choose from.
struct PlanInputs {
    bool geometry = false;                   ///< depth of any view, by `cast`
    std::string cast = "ray";                ///< as in Plan::depth, where there is geometry
    bool streamed_depth = false;             ///< depth of the source came with it
    bool poses = true;                       ///< ordinary video has none
    std::string fill;                        ///< the whole chain, as asked for
    std::vector<std::string> idle_passes{};  ///< of it, those with nothing to fill from
    bool mirrors = true;                     ///< as in Plan
};

/// Those of `plans` that may be played after `chosen` in the middle of a stream. Tracks that `chosen` does not need are
/// left out for good: plans that need one of those that `came` are gone.
std::vector<Plan> plans_after(std::vector<Plan> plans, const Plan& chosen, TrackRoles came);

/// A chain, then the same with one pass fewer each time, down to its last pass alone. What is worth least goes first:
/// guesses, then, over push-pull, in the gaps once the head has moved by 0.25 m, small is worth -1.7 dB, small-wide
/// -1.5, geometry -0.4, earlier +0.1, patches +2.2 and hidden +2.5 (means of an earlier client,
/// docs/results/reproject.md of commit aa35cee6, "What each pass recovers"). Idle passes cost nothing, so they go
/// along with the first other one that is left out.
std::vector<std::string> shorter_chains(const std::string& chain, const std::vector<std::string>& idle_passes);

/// From the most accurate down; the last one is `rotation`. Never empty. docs/decisions/0015-method-auto.md says why
/// these.
std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs);

// `--method auto`: of the ways to play, the most accurate one that keeps to a time, at the start and while playing.

/// Milliseconds of a frame, both eyes.
struct FrameTimes {
    double all = 0;
    double unfilled = 0;  ///< of `all`, what is the same with any fill chain
};

struct Trial {
    FrameTimes milliseconds;
    FilledCounts filled{};  ///< by each pass
};

struct TriedPlan {
    Plan plan;
    Trial trial;
};

struct PassedPlan {
    Plan plan;
    double at_least_ms = 0;  ///< what its method took without filling
};

struct Choice {
    double budget_ms = 0;
    std::int64_t frame = 0;               ///< index of the one that was timed
    std::vector<TriedPlan> tried;         ///< in order
    std::vector<PassedPlan> passed_over;  ///< in order
    std::size_t chosen = 0;               ///< of `tried`
    bool fits = false;                    ///< false: none did, and the chosen one is the fastest that was tried
    std::string next_better{};            ///< the next more accurate plan and its time; empty: there is none

    const Plan& plan() const { return tried[chosen].plan; }
    std::string line() const;  ///< what was chosen and why, in one line
};

/// Plays a frame and says how long it took.
using Measure = std::function<Trial(const Plan&)>;

/// Tries `plans` from the most accurate down, until one keeps to the budget. Where a method is too slow without any
/// filling, its shorter chains are passed over, but for the last plan.
Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const Measure& measure);

struct RechooseOptions {
    std::size_t window = 15;     ///< frames whose median counts; a change is followed by that many at least
    double over = 1.1;           ///< of the budget: a median above it is too slow
    double room = 0.8;           ///< of the budget: what a more accurate plan must be expected to keep to
    std::int64_t patience = 60;  ///< frames since the last change before a step up: 2 s
    std::int64_t longest_patience = 3840;
    std::int64_t retry = 8;  ///< times the patience: wait for a plan that has fitted before, by its best time alone
};

struct Change {
    std::int64_t frame = 0;  ///< index of the first that is played by `to`
    Plan from, to;
    double median_ms = 0;                 ///< what frames took by `from`
    std::optional<double> expected_ms{};  ///< by `to`; nothing: that was never timed whole
    double budget_ms = 0;
    bool is_up = false;  ///< `to` is the more accurate one

    std::string line() const;
};

/// While playing, a plan's time is what its frames took last; as the plan at hand gets slower or faster, so do all.
///
/// Down: to the next plan that may keep to the budget, else to one that is faster than the plan at hand. Up: to the
/// most accurate plan whose time leaves room, and after a longer wait to one whose best time ever did. Whenever a step
/// up is followed by a step down, the next one waits twice as long.
class Rechooser {
public:
    /// `plans` from the most accurate down, the chosen one among them.
    Rechooser(const std::vector<Plan>& plans, const Choice& choice, const RechooseOptions& options = {});

    /// After each frame, with what it took: what is to be played from frame `next` on, where that changes.
    std::optional<Change> played(const FrameTimes& milliseconds, std::int64_t next);

private:
    struct Known {
        Plan plan;
        std::optional<double> ms{}, best_ms{};  ///< nothing: neither tried nor played
    };

    void learn(double median_ms);
    std::optional<std::size_t> cheaper(double median_ms, double unfilled_ms) const;
    std::optional<std::size_t> more_accurate(std::optional<double> Known::*ms) const;
    Change change_to(std::size_t plan, double median_ms, std::int64_t next);

    std::vector<Known> plans_;
    double budget_ms_;
    RechooseOptions options_;
    std::size_t current_ = 0;
    std::deque<FrameTimes> window_;
    std::int64_t frames_since_change_ = 0;
    std::int64_t patience_;
    bool has_median_ = false;  ///< of the plan at hand since it was taken
    bool came_up_ = false;     ///< by the last change
};

}  // namespace equistream::play
