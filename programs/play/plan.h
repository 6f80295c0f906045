#pragma once
/// Ways to play a frame, for `--method auto` (docs/guide/play.md, "Which method").
#include <client/pipeline/decisions.h>

#include <client/warp/engine.h>
#include <equistream/stream.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::play {

/// One way to play a frame.
struct Plan {
    std::string method;
    double mesh_share = default_budget_share;  ///< as in EngineOptions; for mesh only
    std::string depth;    ///< of is_cast, stream (what came with the frames) or none; exact only without auto
    std::string fill;     ///< as in --fill
    bool mirrors = true;  ///< Settings::asks_for_mirrors, the same for all plans of a run
    /// What the pipeline does then.
    PipelineChoice choice() const { return {method, depth, fill, mirrors}; }
    std::string words() const;  ///< "mesh with cells at 1 of the error budget, depth ray, fill pushpull"

    bool operator==(const Plan&) const = default;
};

/// What there is to choose from.
struct PlanInputs {
    bool geometry = false;                  ///< depth of any view, by `cast`
    std::string cast = "ray";               ///< as in Plan::depth, where there is geometry
    bool streamed_depth = false;            ///< depth of the source came with it
    bool poses = true;                      ///< ordinary video has none
    std::string fill;                       ///< the whole ladder, as asked for
    std::vector<std::string> idle_rungs{};  ///< of it, those with nothing to fill from
    bool mirrors = true;                    ///< as in Plan
};

/// Shares of the error budget for mesh cells that are worth telling apart, from the finest. Half the first is no more
/// accurate, and at twice the last one several dB are lost: cells are off by more than what depth agreement allows
/// (plan_test.cpp measures both).
inline constexpr std::array mesh_shares = {default_budget_share, 0.5, 1.0, 2.0};

/// Those of `plans` that may be played after `chosen` in the middle of a stream, whose tracks that `chosen` does not
/// need are left out for good: they need none of these, as far as the source has any (`came`).
std::vector<Plan> plans_after(std::vector<Plan> plans, const Plan& chosen, TrackRoles came);

/// A ladder, then the same with one rung fewer each time, down to its last rung alone. What is worth least goes first:
/// guesses, then, over push-pull, in the gaps once the head has moved by 0.25 m, small is worth -1.7 dB, small-wide
/// -1.5, geometry -0.4, earlier +0.1, patches +2.2 and hidden +2.5 (means of docs/results/reproject.md, "What each rung
/// recovers"). Rungs that are idle cost nothing, so they go along with the first other one that is left out.
std::vector<std::string> shorter_ladders(const std::string& ladder, const std::vector<std::string>& idle_rungs);

/// From the most accurate down; the last one is `rotation`. Never empty. That the eyes' own depth comes before any
/// ladder without it rests on five real scenes (docs/results/reproject.md: with push-pull alone `eye-depth` is ahead of
/// `mesh` by 0.1 to 1.4 dB once the head has moved, and the whole ladder adds 0.0 to 1.0 dB); plan_test.cpp measures
/// the rest.
std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs);

}  // namespace equistream::play
