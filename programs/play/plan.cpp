#include "plan.h"

#include <client/stages/stages.h>
#include <equistream/text.h>

#include <algorithm>
#include <span>
#include <string_view>

namespace equistream::play {

namespace {

std::string joined(const std::vector<std::string_view>& passes) {
    std::string list;
    for (const std::string_view pass : passes)
        list += (list.empty() ? "" : ",") + std::string(pass);
    return list;
}

/// Of a chain, what fills without any depth from anything but the picture itself: its last pass or nothing.
std::string pass_without_depth(const std::string& chain) {
    const std::vector<const FillStage*> stages = parse_fills(chain);
    return !stages.empty() && stages.back()->invents ? std::string(stages.back()->name) : "none";
}

}  // namespace

std::string Plan::words() const {
    return method + ", depth " + depth + ", fill " + fill;
}

std::vector<Plan> plans_after(std::vector<Plan> plans, const Plan& chosen, TrackRoles came) {
    const TrackRoles left_out = came & unneeded_roles(chosen.choice());
    std::erase_if(plans, [&](const Plan& plan) { return (~unneeded_roles(plan.choice()) & left_out).any(); });
    return plans;
}

std::vector<std::string> shorter_chains(const std::string& chain, const std::vector<std::string>& idle_passes) {
    std::vector<std::string> chains{chain};
    if (chain == "none")
        return chains;
    std::vector<std::string_view> passes = split_at_commas(chain);
    const std::string_view last = passes.back();
    passes.pop_back();
    std::erase_if(passes, [&](std::string_view pass) { return std::ranges::count(idle_passes, pass) > 0; });
    const auto worth = [](std::string_view pass) { return find_fill(pass).left_out; };
    while (!passes.empty()) {
        passes.erase(std::ranges::min_element(passes, {}, worth));
        passes.push_back(last);
        chains.push_back(joined(passes));
        passes.pop_back();
    }
    return chains;
}

std::vector<Plan> plans_by_accuracy(const PlanInputs& inputs) {
    std::vector<Plan> plans;
    const auto add = [&](const std::string& method, const std::string& depth, const std::string& fill) {
        plans.push_back({method, depth, fill, inputs.mirrors});
    };
    const std::vector<std::string> chains = shorter_chains(inputs.fill, inputs.idle_passes);
    std::vector<std::string> depths;
    if (inputs.poses && inputs.geometry) {
        depths.push_back(inputs.cast);
        for (const std::string& fill : chains)
            add("eye-depth", inputs.cast, fill);
    }
    if (inputs.poses && inputs.streamed_depth) {
        depths.push_back("stream");
        add("mesh", "stream", inputs.fill);
    }
    // What a depth code loses is worth more than most passes, and less than all but the last together.
    const std::span all(chains);
    for (const std::span part : {all.first(all.size() - 1), all.last(1)})
        for (const std::string& depth : depths)
            for (const std::string& fill : part)
                add("splat", depth, fill);
    const std::string alone = pass_without_depth(inputs.fill);
    if (inputs.poses)
        add("proxy-sphere", "none", alone);
    add("rotation", "none", alone);
    if (alone != "none")
        add("rotation", "none", "none");
    return plans;
}

}  // namespace equistream::play
