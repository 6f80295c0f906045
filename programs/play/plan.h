#pragma once
/// Ways to play a frame, for `--method auto` (docs/guide/play.md, "Which method").
#include <client/pipeline/decisions.h>

#include <equistream/stream.h>

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
/// -1.5, geometry -0.4, earlier +0.1, patches +2.2 and hidden +2.5 (means of docs/results/reproject.md, "What each fill
/// pass recovers"). Idle passes cost nothing, so they go along with the first other one that is left out.
std::vector<std::string> shorter_chains(const std::string& chain, const std::vector<std::string>& idle_passes);

/// From the most accurate down; the last one is `rotation`. Never empty. docs/decisions/0015-method-auto.md says why
/// these.
std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs);

}  // namespace equistream::play
