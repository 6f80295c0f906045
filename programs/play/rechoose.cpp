#include "rechoose.h"

#include <equistream/formatted.h>

#include <algorithm>
#include <cassert>
#include <iterator>

namespace equistream::play {

namespace {

double median(std::vector<double> samples) {
    assert(!samples.empty());
    const auto middle = samples.begin() + std::ptrdiff_t(samples.size() / 2);
    std::ranges::nth_element(samples, middle);
    return *middle;
}

}  // namespace

std::string Change::line() const {
    return formatted("frame %lld: %s to %s, %.1f ms of %.1f expected (%s took %.1f ms)", static_cast<long long>(frame),
                     is_up ? "up" : "down", to.words().c_str(), estimate_ms, budget_ms, from.words().c_str(),
                     median_ms);
}

Rechooser::Rechooser(std::vector<Plan> plans, const Choice& choice, const RechooseOptions& options)
    : plans_(std::move(plans)), budget_ms_(choice.budget_ms), options_(options),
      current_(std::size_t(std::ranges::find(plans_, choice.plan()) - plans_.begin())), known_(choice.known()),
      patience_(options.patience) {
    assert(current_ < plans_.size());
    parts_.reserve(plans_.size());
    std::ranges::transform(plans_, std::back_inserter(parts_), parts_of);
}

std::optional<Change> Rechooser::played(const PartTimes& times, std::int64_t next) {
    window_.push_back(times);
    ++frames_since_change_;
    if (window_.size() < options_.window)
        return std::nullopt;
    if (window_.size() > options_.window)
        window_.pop_front();
    std::vector<double> totals(window_.size());
    std::ranges::transform(window_, totals.begin(), total_ms);
    const double median_ms = median(totals);
    const bool is_over = median_ms > options_.over * budget_ms_;
    const bool may_rise = !is_over && current_ > 0 && frames_since_change_ >= patience_;
    if (!is_over && !may_rise)
        return std::nullopt;
    std::int64_t& next_look = is_over ? next_look_down_ : next_look_up_;
    if (frames_since_change_ < next_look)
        return std::nullopt;
    next_look = frames_since_change_ + std::int64_t(options_.window);
    learn();
    const std::optional<std::size_t> to = is_over ? cheaper(median_ms) : more_accurate();
    if (!to)
        return std::nullopt;
    return change_to(*to, median_ms, next);
}

void Rechooser::learn() {
    PartTimes medians;
    for (const auto& [part, ms] : window_.back()) {
        std::vector<double> samples;
        for (const PartTimes& times : window_)
            if (const auto found = times.find(part); found != times.end())
                samples.push_back(found->second);
        medians[part] = median(samples);
    }
    known_.bring_up_to_date(medians);
}

std::optional<std::size_t> Rechooser::cheaper(double median_ms) const {
    std::optional<std::size_t> fastest;
    for (std::size_t i = current_ + 1; i < plans_.size(); ++i) {
        const double ms = at_most_ms(i);
        if (ms <= budget_ms_)
            return i;
        if (ms < median_ms && (!fastest || ms < at_most_ms(*fastest)))
            fastest = i;
    }
    return fastest;
}

std::optional<std::size_t> Rechooser::more_accurate() const {
    for (std::size_t i = 0; i < current_; ++i)
        if (at_most_ms(i) <= options_.room * budget_ms_)
            return i;
    return std::nullopt;
}

Change Rechooser::change_to(std::size_t plan, double median_ms, std::int64_t next) {
    const bool is_up = plan < current_;
    if (!is_up && came_up_)
        patience_ = std::min(2 * patience_, options_.longest_patience);
    Change change{.frame = next,
                  .from = plans_[current_],
                  .to = plans_[plan],
                  .median_ms = median_ms,
                  .estimate_ms = at_most_ms(plan),
                  .budget_ms = budget_ms_,
                  .is_up = is_up};
    current_ = plan;
    came_up_ = is_up;
    window_.clear();
    frames_since_change_ = next_look_down_ = next_look_up_ = 0;
    return change;
}

}  // namespace equistream::play
