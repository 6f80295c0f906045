#include "plan.h"

#include <equistream/comma_list.h>
#include <equistream/formatted.h>

#include <algorithm>
#include <cassert>
#include <span>

namespace equistream::play {

namespace {

/// The ladder's cheapest end: what fills everything that is left.
std::string last_rung(const std::string& ladder) {
    return ladder == "none" ? ladder : std::string(split_at_commas(ladder).back());
}

/// Without the rungs that draw or look up in further pictures of the geometry.
bool is_whole(const std::string& ladder) {
    return ladder == "none" || split_at_commas(ladder).size() == 1;
}

/// Of a ladder, what fills without any depth from anything but the picture itself: its last rung or nothing.
std::string rung_without_depth(const std::string& ladder) {
    const std::string last = last_rung(ladder);
    return last == "pushpull" || last == "spread" ? last : "none";
}

}  // namespace

std::string Plan::words() const {
    std::string text = method;
    if (method == "mesh")
        text += " with cells at " + in_words(mesh_share) + " of the error budget";
    return text + ", depth " + depth + ", fill " + fill;
}

DepthNeeds needs_when_moved(const Engine& engine) {
    return engine.needs_depth(Pose{}, Pose{{1, 0, 0}, {1, 0, 0, 0}});
}

TrackRoles unneeded_roles(const Plan& plan) {
    const bool with_depth = needs_when_moved(*make_engine(plan.method)).any();
    const std::vector<std::string_view> rungs = split_at_commas(plan.fill);
    TrackRoles unneeded;
    const auto leave_out = [&](TrackRole role, bool needed) { unneeded[std::size_t(role)] = !needed; };
    const auto fills = [&](std::string_view rung) { return std::ranges::count(rungs, rung) > 0; };
    leave_out(TrackRole::small, std::ranges::any_of(small_rung_names(), fills));
    // All others are looked up by the eye's depth, mirrors too.
    leave_out(TrackRole::depth, with_depth && plan.depth != "ray");
    leave_out(TrackRole::images, with_depth);
    leave_out(TrackRole::hidden, with_depth && fills("hidden"));
    leave_out(TrackRole::hidden_depth, with_depth && fills("hidden"));
    leave_out(TrackRole::patches, with_depth && fills("patches"));
    leave_out(TrackRole::patches_depth, with_depth && fills("patches"));
    return unneeded;
}

std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs) {
    std::vector<std::string> depths, ladders{inputs.fill};
    if (inputs.poses && inputs.geometry)
        depths.push_back("ray");
    if (inputs.poses && inputs.streamed_depth)
        depths.push_back("stream");
    if (!is_whole(inputs.fill))
        ladders.push_back(last_rung(inputs.fill));
    std::vector<Plan> plans;
    // Rungs are worth more than the depth that codes lose.
    const auto add = [&](const std::string& method, double share, std::span<const std::string> fills) {
        for (const std::string& fill : fills)
            for (const std::string& depth : depths)
                plans.push_back({method, share, depth, fill});
    };
    const std::span all(ladders), last = all.last(1);
    if (inputs.geometry)  // the eyes' own depth
        add("surface", 0.25, all);
    add("mesh", 0.25, all);
    add("mesh", 1, last);
    add("splat", 0.25, last);
    const std::string alone = rung_without_depth(inputs.fill);
    if (inputs.poses)
        plans.push_back({"lean", 0.25, "none", alone});
    plans.push_back({"sphere", 0.25, "none", alone});
    if (alone != "none")
        plans.push_back({"sphere", 0.25, "none", "none"});
    return plans;
}

Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const std::function<Trial(const Plan&)>& measure) {
    assert(!plans.empty());
    Choice choice;
    choice.budget_ms = budget_ms;
    for (const Plan& plan : plans) {
        choice.tried.push_back({plan, measure(plan)});
        choice.chosen = choice.tried.size() - 1;
        choice.fits = choice.tried.back().trial.milliseconds <= budget_ms;
        if (choice.fits)
            return choice;
    }
    const auto fastest =
        std::ranges::min_element(choice.tried, {}, [](const TriedPlan& tried) { return tried.trial.milliseconds; });
    choice.chosen = std::size_t(fastest - choice.tried.begin());
    return choice;
}

std::string Choice::line() const {
    const TriedPlan& taken = tried[chosen];
    std::string text =
        formatted("%s: %.1f ms of %.1f", taken.plan.words().c_str(), taken.trial.milliseconds, budget_ms);
    if (!fits)
        return text + " (nothing fits; this is the fastest)";
    if (chosen == 0)
        return text + " (the most accurate there is)";
    const TriedPlan& better = tried[chosen - 1];
    return text + formatted(" (next better: %s, %.1f ms)", better.plan.words().c_str(), better.trial.milliseconds);
}

}  // namespace equistream::play
