#include "choice.h"

#include <equistream/formatted.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>
#include <utility>

namespace equistream::play {

namespace {

class Search {
public:
    Search(const std::vector<Plan>& plans, double budget_ms, const Measure& measure)
        : plans_(plans), measure_(measure), is_tried_(plans.size()), estimates_ms_(plans.size()) {
        assert(!plans.empty());
        choice_.budget_ms = budget_ms;
    }

    Choice run() {
        for (std::size_t i = 0; i < plans_.size() && !choice_.fits; ++i) {
            estimates_ms_[i] = known_.at_least_ms(plans_[i]);
            if (i == 0 || estimates_ms_[i] <= choice_.budget_ms)
                try_plan(i);
        }
        if (!choice_.fits)
            find_fastest();
        const std::size_t end = choice_.fits ? index_of(choice_.plan()) : plans_.size();
        for (std::size_t i = 0; i < end; ++i)
            if (!is_tried_[i])
                choice_.passed_over.push_back({plans_[i], estimates_ms_[i]});
        if (choice_.fits && end > 0)
            choice_.next_better = reason_against(end - 1);
        return std::move(choice_);
    }

private:
    std::size_t index_of(const Plan& plan) const {
        return std::size_t(std::ranges::find(plans_, plan) - plans_.begin());
    }

    std::string reason_against(std::size_t i) const {
        const std::string words = plans_[i].words();
        if (!is_tried_[i])
            return formatted("%s, %.1f ms estimated", words.c_str(), estimates_ms_[i]);
        const auto tried = std::ranges::find(choice_.tried, plans_[i], &TriedPlan::plan);
        return formatted("%s, %.1f ms tried", words.c_str(), tried->trial.milliseconds());
    }

    void try_plan(std::size_t i) {
        const double estimate_ms = known_.at_least_ms(plans_[i]);
        choice_.tried.push_back({plans_[i], measure_(plans_[i]), estimate_ms});
        is_tried_[i] = true;
        const Trial& trial = choice_.tried.back().trial;
        known_.learn(trial.parts);
        choice_.fits = trial.milliseconds() <= choice_.budget_ms;
        if (choice_.fits || trial.milliseconds() < choice_.tried[choice_.chosen].trial.milliseconds())
            choice_.chosen = choice_.tried.size() - 1;
    }

    void find_fastest() {
        while (!choice_.fits) {
            std::optional<std::size_t> next;
            for (std::size_t i = 0; i < plans_.size(); ++i)
                // Of equals the least accurate: what is not known of it is the least work.
                if (!is_tried_[i] && (!next || known_.at_least_ms(plans_[i]) <= known_.at_least_ms(plans_[*next])))
                    next = i;
            if (!next || known_.at_least_ms(plans_[*next]) >= choice_.tried[choice_.chosen].trial.milliseconds())
                return;
            try_plan(*next);
        }
    }

    const std::vector<Plan>& plans_;
    const Measure& measure_;
    std::vector<bool> is_tried_;
    std::vector<double> estimates_ms_;  ///< when it was their turn
    KnownTimes known_;
    Choice choice_;
};

}  // namespace

Choice choose_plan(const std::vector<Plan>& plans, double budget_ms, const Measure& measure) {
    return Search(plans, budget_ms, measure).run();
}

void survey(const std::vector<Plan>& plans, const Measure& measure, Choice& choice) {
    KnownTimes known = choice.known();
    for (const Plan& plan : plans)
        if (!std::isfinite(known.at_most_ms(plan))) {
            choice.surveyed.push_back({plan, measure(plan)});
            known.learn(choice.surveyed.back().trial.parts);
        }
}

KnownTimes Choice::known() const {
    KnownTimes known;
    for (const auto* trials : {&tried, &surveyed})
        for (const TriedPlan& trial : *trials)
            known.learn(trial.trial.parts);
    known.learn(tried[chosen].trial.parts);
    return known;
}

std::string Choice::line() const {
    const TriedPlan& taken = tried[chosen];
    std::string text =
        formatted("%s: %.1f ms of %.1f", taken.plan.words().c_str(), taken.trial.milliseconds(), budget_ms);
    if (!fits)
        text += " (nothing fits; this is the fastest";
    else if (next_better.empty())
        text += " (the most accurate there is";
    else
        text += " (next better: " + next_better;
    return text + formatted("; %zu tried, %zu passed over by estimate)", tried.size(), passed_over.size());
}

}  // namespace equistream::play
