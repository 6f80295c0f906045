#include "plan.h"

#include <client/stages/stages.h>
#include <equistream/comma_list.h>
#include <equistream/formatted.h>

#include <algorithm>
#include <span>

namespace equistream::play {

namespace {

/// How many rungs of a ladder fill with what is truly there.
std::ptrdiff_t rungs_of_worth(const std::string& ladder, const std::vector<std::string>& idle_rungs) {
    return std::ranges::count_if(parse_fills(ladder), [&](const FillStage* stage) {
        return stage->shows_truth && std::ranges::count(idle_rungs, stage->name) == 0;
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
    const std::vector<const FillStage*> stages = parse_fills(ladder);
    return !stages.empty() && stages.back()->invents ? std::string(stages.back()->name) : "none";
}

}  // namespace

std::string Plan::words() const {
    std::string text = method;
    if (method == "mesh")
        text += " with cells at " + in_words(mesh_share) + " of the error budget";
    return text + ", depth " + depth + ", fill " + fill;
}

std::vector<Plan> plans_after(std::vector<Plan> plans, const Plan& chosen, TrackRoles came) {
    const TrackRoles left_out = came & unneeded_roles(chosen.choice());
    std::erase_if(plans, [&](const Plan& plan) { return (~unneeded_roles(plan.choice()) & left_out).any(); });
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
    const auto worth = [](std::string_view rung) { return find_fill(rung).left_out; };
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
            add("eye-depth", any_share, fill);
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
        plans.push_back({"proxy-sphere", any_share[0], "none", alone});
    plans.push_back({"rotation", any_share[0], "none", alone});
    if (alone != "none")
        plans.push_back({"rotation", any_share[0], "none", "none"});
    for (Plan& plan : plans)
        plan.mirrors = inputs.mirrors;
    return plans;
}

}  // namespace equistream::play
