#pragma once
/// Of all ways to play a frame, the most accurate one that keeps to a time, found with few trials.
#include "plan_times.h"

#include <client/fill/fill.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace equistream::play {

/// A frame, both eyes.
struct Trial {
    PartTimes parts;
    FilledCounts filled{};  ///< by each rung

    double milliseconds() const { return total_ms(parts); }
};

struct TriedPlan {
    Plan plan;
    Trial trial;
    double estimate_ms = 0;  ///< what it was known to take at least before it was tried
};

struct PassedPlan {
    Plan plan;
    double estimate_ms = 0;  ///< what it was known to take at least when it was its turn
};

struct Choice {
    double budget_ms = 0;
    std::int64_t frame = 0;               ///< index of the one that was played
    std::vector<TriedPlan> tried;         ///< in order
    std::vector<PassedPlan> passed_over;  ///< by their estimate, in order of accuracy
    std::vector<TriedPlan> surveyed;      ///< by survey
    std::size_t chosen = 0;               ///< of `tried`
    bool fits = false;                    ///< false: none did, and the chosen one is the fastest
    std::string next_better{};            ///< what kept the next more accurate plan from being chosen; empty: none is

    const Plan& plan() const { return tried[chosen].plan; }
    /// By all trials; of parts that were timed more than once, the chosen plan's.
    KnownTimes known() const;
    std::string line() const;  ///< what was chosen and why, in one line
};

/// Plays a frame a few times and says how long each part of it took.
using Measure = std::function<Trial(const Plan&)>;

/// Goes through `plans` once, from the most accurate down. A plan of which what is known of its parts exceeds the
/// budget already is passed over; any other is tried, which makes its parts known; the first that a trial shows to keep
/// to the budget is taken, so never one on an estimate alone. A first trial tells of a method all but what other depth
/// and mesh density change: that makes about as many trials as there are methods, depths and densities together, not
/// their product with ladders. Where none fits, plans are tried from the one that may be fastest on until no other can
/// be faster than the fastest tried.
Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const Measure& measure);

/// Tries plans of which some part was in no trial yet, so that what all plans take is known when one is chosen again
/// while playing.
void survey(const std::vector<Plan>& plans, const Measure& measure, Choice& choice);

}  // namespace equistream::play
