#include "plan_times.h"

#include <equistream/comma_list.h>

#include <algorithm>
#include <limits>
#include <numeric>

namespace equistream::play {

double total_ms(const PartTimes& times) {
    return std::accumulate(times.begin(), times.end(), 0.0,
                           [](double sum, const auto& entry) { return sum + entry.second; });
}

namespace part {

Part frame() {
    return {"frame"};
}

Part track(std::string_view name) {
    return {"track " + std::string(name)};
}

Part depth(const Plan& plan) {
    return {"depth " + plan.depth + " for " + plan.method};
}

Part depth_of(const Plan& plan, std::string_view track) {
    return {"depth " + plan.depth + " of " + std::string(track)};
}

Part reproject(const Plan& plan) {
    return {"reproject " + plan.method, plan.method == "mesh" ? plan.mesh_share : 0};
}

Part fill(const Plan& plan, std::string_view rung) {
    return {"fill " + std::string(rung) + " after " + plan.method};
}

Part reliability() {
    return {"reliability"};
}

}  // namespace part

bool is_decoding(const Part& part) {
    return part == part::frame() || part.name.starts_with("track ");
}

std::vector<Part> parts_of(const Plan& plan) {
    std::vector<Part> parts{part::frame(), part::reproject(plan), part::reliability()};
    const bool with_depth = plan.depth != "none";
    if (with_depth)
        parts.push_back(part::depth(plan));
    const TrackRoles unneeded = unneeded_roles(plan.choice());
    const auto needs = [&](TrackRole role) { return !unneeded[std::size_t(role)]; };
    for (const auto& [role, name] :
         {std::pair{TrackRole::small, "small"}, {TrackRole::hidden, "hidden"}, {TrackRole::patches, "patches"}}) {
        if (!needs(role))
            continue;
        parts.push_back(part::track(name));
        if (with_depth && role != TrackRole::hidden)
            parts.push_back(part::depth_of(plan, name));
    }
    if (plan.fill != "none")
        for (const std::string_view rung : split_at_commas(plan.fill))
            if (const Part part = part::fill(plan, rung); std::ranges::count(parts, part) == 0)
                parts.push_back(part);
    return parts;
}

namespace {

/// The first word of its name.
std::string_view kind_of(const Part& part) {
    return std::string_view(part.name).substr(0, part.name.find(' '));
}

/// Of several parts together.
struct Growth {
    double before_ms = 0, now_ms = 0;

    /// A part that changes likewise. More than `slower` at once is no slower machine but other work.
    double scaled(double ms) const {
        constexpr double slower = 4;
        if (before_ms <= 0)
            return ms;
        const double scaled_ms = ms * now_ms / before_ms;
        return now_ms > slower * before_ms ? std::min(scaled_ms, std::max(ms, now_ms)) : scaled_ms;
    }
};

}  // namespace

void KnownTimes::learn(const PartTimes& times) {
    for (const auto& [part, ms] : times)
        times_[part] = ms;
}

void KnownTimes::bring_up_to_date(const PartTimes& times) {
    Growth together;
    std::map<std::string_view, Growth> by_kind;
    for (const auto& [part, ms] : times)
        if (const auto known = times_.find(part); known != times_.end() && !is_decoding(part))
            for (Growth* growth : {&together, &by_kind[kind_of(part)]}) {
                growth->before_ms += known->second;
                growth->now_ms += ms;
            }
    for (auto& [part, ms] : times_)
        if (!is_decoding(part)) {
            const auto own = by_kind.find(kind_of(part));
            ms = (own != by_kind.end() ? own->second : together).scaled(ms);
        }
    learn(times);
}

double KnownTimes::at_least_ms(const Plan& plan) const {
    return bound_ms(parts_of(plan), Bound::lower);
}

double KnownTimes::at_most_ms(std::span<const Part> parts) const {
    return bound_ms(parts, Bound::upper);
}

double KnownTimes::bound_ms(std::span<const Part> parts, Bound bound) const {
    double sum = 0;
    for (const Part& part : parts)
        sum += bound_ms(part, bound);
    return sum;
}

double KnownTimes::bound_ms(const Part& part, Bound bound) const {
    if (const auto known = times_.find(part); known != times_.end())
        return known->second;
    double lower = 0, upper = std::numeric_limits<double>::infinity();
    if (part.mesh_share > 0)
        for (const auto& [other, ms] : times_)
            if (other.name == part.name) {
                const double cells = other.mesh_share / part.mesh_share;
                lower = std::max(lower, ms * std::min(cells, 1.0));
                upper = std::min(upper, ms * std::max(cells, 1.0));
            }
    return bound == Bound::lower ? lower : std::max(lower, upper);
}

}  // namespace equistream::play
