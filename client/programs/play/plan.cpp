#include "plan.h"

#include <equistream/comma_list.h>
#include <equistream/formatted.h>
#include <equistream_client/fill.h>

#include <algorithm>
#include <span>

namespace equistream::play {

namespace {

/// The ladder's cheapest end: what fills everything that is left.
std::string last_rung(const std::string& ladder) {
    return ladder == "none" ? ladder : std::string(split_at_commas(ladder).back());
}

/// From what is worth least.
constexpr std::array<std::string_view, 8> rungs_by_worth = {"spread",   "pushpull", "small",   "small-wide",
                                                            "geometry", "earlier",  "patches", "hidden"};

/// How many rungs of a ladder fill with what is truly there: 2 dB and more in the gaps.
std::ptrdiff_t rungs_of_worth(const std::string& ladder, const std::vector<std::string>& idle_rungs) {
    return std::ranges::count_if(split_at_commas(ladder), [&](std::string_view rung) {
        return (rung == "hidden" || rung == "patches") && std::ranges::count(idle_rungs, rung) == 0;
    });
}

std::string joined(const std::vector<std::string_view>& rungs) {
    std::string list;
    for (const std::string_view rung : rungs)
        list += (list.empty() ? "" : ",") + std::string(rung);
    return list;
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

bool is_drawn(std::string_view depth) {
    return depth == "gl" || depth == "gl-cube";
}

bool is_cast(std::string_view depth) {
    return depth == "ray" || is_drawn(depth);
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
    const auto looks_points_up = [](const auto& rung) { return rung->wants_depth(); };
    leave_out(TrackRole::small, std::ranges::any_of(small_rung_names(), fills));
    // All others are looked up by the eye's depth, mirrors too.
    leave_out(TrackRole::depth, with_depth && !is_cast(plan.depth));
    leave_out(TrackRole::images,
              with_depth && (plan.mirrors || std::ranges::any_of(make_fill_ladder(plan.fill), looks_points_up)));
    leave_out(TrackRole::hidden, with_depth && fills("hidden"));
    leave_out(TrackRole::hidden_depth, with_depth && fills("hidden"));
    leave_out(TrackRole::patches, with_depth && fills("patches"));
    leave_out(TrackRole::patches_depth, with_depth && fills("patches"));
    return unneeded;
}

std::vector<Plan> plans_after(std::vector<Plan> plans, const Plan& chosen, TrackRoles came) {
    const TrackRoles left_out = came & unneeded_roles(chosen);
    std::erase_if(plans, [&](const Plan& plan) { return (~unneeded_roles(plan) & left_out).any(); });
    return plans;
}

std::vector<std::string> shorter_ladders(const std::string& ladder, const std::vector<std::string>& idle_rungs) {
    std::vector<std::string> ladders{ladder};
    if (ladder == "none")
        return ladders;
    std::vector<std::string_view> rungs = split_at_commas(ladder);
    const std::string_view last = rungs.back();
    rungs.pop_back();
    std::erase_if(rungs, [&](std::string_view rung) { return std::ranges::count(idle_rungs, rung) > 0; });
    const auto worth = [](std::string_view rung) { return std::ranges::find(rungs_by_worth, rung); };
    while (!rungs.empty()) {
        rungs.erase(std::ranges::min_element(rungs, {}, worth));
        rungs.push_back(last);
        ladders.push_back(joined(rungs));
        rungs.pop_back();
    }
    return ladders;
}

std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs) {
    std::vector<std::string> depths;
    if (inputs.poses && inputs.geometry)
        depths.push_back(inputs.cast);
    if (inputs.poses && inputs.streamed_depth)
        depths.push_back("stream");
    std::vector<Plan> plans;
    // Rungs are worth more than density of the mesh, and that more than the depth that codes lose. What splatting loses
    // is more than most rungs are worth, but less than those of rungs_of_worth are; what a code loses shows more in it.
    const auto add = [&](const std::string& method, std::span<const double> shares, const std::string& fill) {
        for (const double share : shares)
            for (const std::string& depth : depths)
                plans.push_back({method, share, depth, fill});
    };
    const std::array any_share = {EngineOptions{}.mesh_share};
    const std::vector<std::string> ladders = shorter_ladders(inputs.fill, inputs.idle_rungs);
    if (inputs.geometry)  // the eyes' own depth
        for (const std::string& fill : ladders)
            add("surface", any_share, fill);
    for (auto first = ladders.begin(); first != ladders.end();) {
        const auto last = std::ranges::find_if(first, ladders.end(), [&](const std::string& ladder) {
            return rungs_of_worth(ladder, inputs.idle_rungs) != rungs_of_worth(*first, inputs.idle_rungs);
        });
        const std::span alike(first, last);
        for (const std::string& fill : alike)
            add("mesh", mesh_shares, fill);
        for (const std::string& depth : depths)
            for (const std::string& fill : alike)
                plans.push_back({"splat", any_share[0], depth, fill});
        first = last;
    }
    const std::string alone = rung_without_depth(inputs.fill);
    if (inputs.poses)
        plans.push_back({"lean", any_share[0], "none", alone});
    plans.push_back({"sphere", any_share[0], "none", alone});
    if (alone != "none")
        plans.push_back({"sphere", any_share[0], "none", "none"});
    for (Plan& plan : plans)
        plan.mirrors = inputs.mirrors;
    return plans;
}

}  // namespace equistream::play
