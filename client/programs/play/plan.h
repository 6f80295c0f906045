#pragma once
/// `--method auto`: of all ways to play a frame, the most accurate one that keeps to a time.
///
/// Ways are tried in one fixed order, from the most accurate down, on one frame and this machine, until one fits
/// (docs/guide.md, "Choosing by time").
#include <equistream/stream.h>
#include <equistream_client/engine.h>
#include <equistream_client/fill.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace equistream::play {

/// One way to play a frame.
struct Plan {
    std::string method;
    double mesh_share = 0.25;   ///< as in EngineOptions; for mesh only
    std::string depth;          ///< ray, stream or exact (what came with the frames), or none
    std::string fill;           ///< as in --fill
    std::string words() const;  ///< "mesh with cells at 1 of the error budget, depth ray, fill pushpull"
};

/// What there is to choose from.
struct PlanInputs {
    bool geometry = false;        ///< depth of any view, by casting rays
    bool streamed_depth = false;  ///< depth of the source came with it
    bool poses = true;            ///< ordinary video has none
    std::string fill;             ///< the whole ladder, as asked for
};

/// Whose depth a method cannot do without once the eye moves.
DepthNeeds needs_when_moved(const Engine& engine);

/// What of a source a way to play it has no use for.
TrackRoles unneeded_roles(const Plan& plan);

/// From the most accurate down; the last one is `sphere`. Never empty.
std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs);

/// A frame, both eyes.
struct Trial {
    double milliseconds = 0;
    FilledCounts filled{};  ///< by each rung
};

struct TriedPlan {
    Plan plan;
    Trial trial;
};

struct Choice {
    double budget_ms = 0;
    std::int64_t frame = 0;        ///< index of the one that was played
    std::vector<TriedPlan> tried;  ///< in order; those after the chosen one were not tried
    std::size_t chosen = 0;        ///< of `tried`
    bool fits = false;             ///< false: none did, and the chosen one is the fastest

    std::string line() const;  ///< what was chosen and why, in one line
};

/// `measure` plays a frame and says how long it took.
Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const std::function<Trial(const Plan&)>& measure);

}  // namespace equistream::play
