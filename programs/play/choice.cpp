#include "choice.h"

#include <equistream/text.h>

#include <client/stages/stages.h>

#include <algorithm>
#include <cassert>
#include <span>
#include <string_view>

namespace equistream::play {

namespace {

double median(const std::deque<FrameTimes>& window, double FrameTimes::*ms) {
    std::vector<double> samples(window.size());
    std::ranges::transform(window, samples.begin(), [&](const FrameTimes& times) { return times.*ms; });
    const auto middle = samples.begin() + std::ptrdiff_t(samples.size() / 2);
    std::ranges::nth_element(samples, middle);
    return *middle;
}

}  // namespace

Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const Measure& measure) {
    Choice choice;
    choice.budget_ms = budget_ms;
    std::string before;
    for (const Plan& plan : plans) {
        const auto alike =
            std::ranges::find_if(choice.tried, [&](const TriedPlan& tried) { return tried.plan.reprojects_as(plan); });
        // Where nothing fits, the last one is the fastest: it is always tried.
        const bool is_last = &plan == &plans.back();
        if (!is_last && alike != choice.tried.end() && alike->trial.milliseconds.unfilled > budget_ms) {
            choice.passed_over.push_back({plan, alike->trial.milliseconds.unfilled});
            before = formatted("%s, at least %.1f ms", plan.words().c_str(), choice.passed_over.back().at_least_ms);
            continue;
        }
        choice.tried.push_back({plan, measure(plan)});
        const double ms = choice.tried.back().trial.milliseconds.all;
        choice.fits = ms <= budget_ms;
        if (choice.fits || ms < choice.tried[choice.chosen].trial.milliseconds.all)
            choice.chosen = choice.tried.size() - 1;
        if (choice.fits)
            break;
        before = formatted("%s, %.1f ms tried", plan.words().c_str(), ms);
    }
    if (choice.fits)
        choice.next_better = before;
    return choice;
}

std::string Choice::line() const {
    std::string text =
        formatted("%s: %.1f ms of %.1f", plan().words().c_str(), tried[chosen].trial.milliseconds.all, budget_ms);
    if (!fits)
        text += " (nothing fits; this is the fastest tried";
    else if (next_better.empty())
        text += " (the most accurate there is";
    else
        text += " (next better: " + next_better;
    return text + formatted("; %zu tried, %zu passed over)", tried.size(), passed_over.size());
}

std::string Change::line() const {
    const std::string expected = expected_ms ? formatted(", %.1f ms expected", *expected_ms) : "";
    return formatted("frame %lld: %s to %s%s (%s took %.1f ms of %.1f)", static_cast<long long>(frame),
                     is_up ? "up" : "down", to.words().c_str(), expected.c_str(), from.words().c_str(), median_ms,
                     budget_ms);
}

Rechooser::Rechooser(const std::vector<Plan>& plans, const Choice& choice, const RechooseOptions& options)
    : budget_ms_(choice.budget_ms), options_(options), patience_(options.patience), has_median_(true) {
    for (const Plan& plan : plans) {
        if (plan == choice.plan())
            current_ = plans_.size();
        Known& known = plans_.emplace_back(plan);
        if (const auto tried = std::ranges::find(choice.tried, plan, &TriedPlan::plan); tried != choice.tried.end())
            known.ms = known.best_ms = tried->trial.milliseconds.all;
        if (const auto passed = std::ranges::find(choice.passed_over, plan, &PassedPlan::plan);
            passed != choice.passed_over.end())
            known.ms = passed->at_least_ms;
    }
    assert(plans_[current_].ms);
}

std::optional<Change> Rechooser::played(const FrameTimes& milliseconds, std::int64_t next) {
    window_.push_back(milliseconds);
    ++frames_since_change_;
    if (window_.size() < options_.window)
        return std::nullopt;
    if (window_.size() > options_.window)
        window_.pop_front();
    const double median_ms = median(window_, &FrameTimes::all);
    learn(median_ms);
    std::optional<std::size_t> to;
    const bool is_over = median_ms > options_.over * budget_ms_;
    if (is_over)
        to = cheaper(median_ms, median(window_, &FrameTimes::unfilled));
    else if (frames_since_change_ >= patience_)
        to = more_accurate(&Known::ms);
    if (!to && !is_over && frames_since_change_ >= std::min(options_.retry * patience_, options_.longest_patience))
        to = more_accurate(&Known::best_ms);
    if (!to)
        return std::nullopt;
    return change_to(*to, median_ms, next);
}

void Rechooser::learn(double median_ms) {
    const double change = has_median_ ? median_ms / *plans_[current_].ms : 1;
    for (Known& known : plans_)
        if (known.ms)
            *known.ms *= change;
    Known& current = plans_[current_];
    current.ms = median_ms;
    current.best_ms = std::min(current.best_ms.value_or(median_ms), median_ms);
    has_median_ = true;
}

std::optional<std::size_t> Rechooser::cheaper(double median_ms, double unfilled_ms) const {
    const auto is_too_slow = [&](const Plan& plan) {
        return unfilled_ms > budget_ms_ && plan.reprojects_as(plans_[current_].plan);
    };
    for (const double limit_ms : {budget_ms_, median_ms})
        for (std::size_t i = current_ + 1; i < plans_.size(); ++i)
            if (!is_too_slow(plans_[i].plan) && plans_[i].ms.value_or(0) < limit_ms)
                return i;
    return std::nullopt;
}

std::optional<std::size_t> Rechooser::more_accurate(std::optional<double> Known::*ms) const {
    for (std::size_t i = 0; i < current_; ++i)
        if ((plans_[i].*ms).value_or(budget_ms_) <= options_.room * budget_ms_)
            return i;
    return std::nullopt;
}

Change Rechooser::change_to(std::size_t plan, double median_ms, std::int64_t next) {
    const bool is_up = plan < current_;
    if (!is_up && came_up_)
        patience_ = std::min(2 * patience_, options_.longest_patience);
    Change change{.frame = next,
                  .from = plans_[current_].plan,
                  .to = plans_[plan].plan,
                  .median_ms = median_ms,
                  .expected_ms = plans_[plan].best_ms ? plans_[plan].ms : std::nullopt,
                  .budget_ms = budget_ms_,
                  .is_up = is_up};
    current_ = plan;
    came_up_ = is_up;
    has_median_ = false;
    window_.clear();
    frames_since_change_ = 0;
    return change;
}

namespace {

std::string joined(const std::vector<std::string_view>& passes) {
    std::string list;
    for (const std::string_view pass : passes)
        list += (list.empty() ? "" : ",") + std::string(pass);
    return list;
}

/// What lies around a window is no gap: this pass is never left out to save time.
constexpr std::string_view around_windows = "base";

/// Of a chain, what fills without any depth: what lies around a window, and its last pass if that invents.
std::vector<std::string_view> passes_without_depth(const PlanInputs& inputs) {
    std::vector<std::string_view> passes;
    const std::vector<const FillStage*> stages = parse_fills(inputs.fill);
    for (const FillStage* stage : stages)
        if ((stage->name == around_windows && std::ranges::count(inputs.idle_passes, stage->name) == 0) ||
            (stage == stages.back() && stage->invents))
            passes.push_back(stage->name);
    return passes;
}

std::string joined_or_none(const std::vector<std::string_view>& passes) {
    return passes.empty() ? "none" : joined(passes);
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
    const bool has_window = std::erase(passes, around_windows) > 0;
    const auto worth = [](std::string_view pass) { return find_fill(pass).left_out; };
    while (!passes.empty()) {
        passes.erase(std::ranges::min_element(passes, {}, worth));
        std::vector<std::string_view> shorter = passes;
        if (has_window)
            shorter.push_back(around_windows);
        shorter.push_back(last);
        chains.push_back(joined(shorter));
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
    std::vector<std::string_view> without_depth = passes_without_depth(inputs);
    const std::string alone = joined_or_none(without_depth);
    if (inputs.poses)
        add("proxy-sphere", "none", alone);
    add("rotation", "none", alone);
    std::erase_if(without_depth, [](std::string_view pass) { return pass != around_windows; });
    if (const std::string least = joined_or_none(without_depth); least != alone)
        add("rotation", "none", least);
    return plans;
}

}  // namespace equistream::play
