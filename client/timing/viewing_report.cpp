#include "viewing_report.h"

#include <equistream/conventions.h>
#include <equistream/formatted.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace equistream {

namespace {

using Json = nlohmann::ordered_json;

double degrees_between(const glm::dquat& a, const glm::dquat& b) {
    const glm::dquat turn = glm::conjugate(a) * b;
    return 2 * std::atan2(glm::length(glm::dvec3(turn.x, turn.y, turn.z)), std::abs(turn.w)) * 180 / pi;
}

Json quantiles_json(const Quantiles& spread) {
    return {{"mean", spread.mean}, {"median", spread.median}, {"p95", spread.p95}, {"max", spread.max}};
}

Json refresh_json(const ViewedRefresh& refresh) {
    Json json = {{"number", refresh.number},
                 {"display_s", refresh.display_s},
                 {"state", clock_state_names[std::size_t(refresh.state)]}};
    if (!refresh.frame)
        return json;
    json["frame"] = refresh.frame->number;
    json["previous"] = refresh.previous ? Json(refresh.previous->number) : Json();
    json["rate"] = refresh.rate;
    json["age_ms"] = 1e3 * refresh.age_s();
    json["carried_on_ms"] = 1e3 * refresh.extrapolated_s;
    json["ahead_ms"] = 1e3 * refresh.ahead_s;
    json["error_deg"] = refresh.error_deg();
    json["error_m"] = refresh.error_m();
    json["unreprojected_error_deg"] = refresh.unreprojected_error_deg();
    json["unreprojected_error_m"] = refresh.unreprojected_error_m();
    return json;
}

}  // namespace

double ViewedRefresh::error_deg() const {
    return degrees_between(predicted_head.orientation, true_head.orientation);
}
double ViewedRefresh::error_m() const {
    return glm::distance(predicted_head.position_m, true_head.position_m);
}
double ViewedRefresh::unreprojected_error_deg() const {
    return degrees_between(frame->pose.orientation, true_head.orientation);
}
double ViewedRefresh::unreprojected_error_m() const {
    return glm::distance(frame->pose.position_m, true_head.position_m);
}

Quantiles quantiles_of(std::vector<double> values) {
    if (values.empty())
        return {};
    std::ranges::sort(values);
    const auto ranked = [&](double share) {
        const auto rank = std::size_t(std::ceil(share * double(values.size())));
        return values[std::clamp<std::size_t>(rank, 1, values.size()) - 1];
    };
    return {std::accumulate(values.begin(), values.end(), 0.0) / double(values.size()), ranked(0.5), ranked(0.95),
            values.back()};
}

ViewingReport report_viewing(std::span<const ViewedRefresh> refreshes, double refresh_hz) {
    ViewingReport report;
    report.refresh_hz = refresh_hz;
    report.refreshes = std::int64_t(refreshes.size());
    std::vector<ViewedRefresh> seen;
    std::vector<std::int64_t> shown;
    for (const ViewedRefresh& refresh : refreshes) {
        report.state_s[std::size_t(refresh.state)] += 1 / refresh_hz;
        if (!refresh.frame) {
            ++report.blank;
            continue;
        }
        report.repeated += !seen.empty() && seen.back().frame->number == refresh.frame->number;
        seen.push_back(refresh);
        shown.push_back(refresh.frame->number);
    }
    std::ranges::sort(shown);
    report.frames_shown = std::unique(shown.begin(), shown.end()) - shown.begin();
    const auto spread = [&](const auto& figure) {
        std::vector<double> values(seen.size());
        std::ranges::transform(seen, values.begin(), figure);
        return quantiles_of(std::move(values));
    };
    report.age_ms = spread([](const ViewedRefresh& r) { return 1e3 * r.age_s(); });
    report.extrapolated_ms = spread([](const ViewedRefresh& r) { return 1e3 * r.extrapolated_s; });
    report.error_deg = spread([](const ViewedRefresh& r) { return r.error_deg(); });
    report.error_m = spread([](const ViewedRefresh& r) { return r.error_m(); });
    report.unreprojected_error_deg = spread([](const ViewedRefresh& r) { return r.unreprojected_error_deg(); });
    report.unreprojected_error_m = spread([](const ViewedRefresh& r) { return r.unreprojected_error_m(); });
    return report;
}

std::string ViewingReport::table() const {
    std::string text = formatted("%lld refreshes at %s Hz: %lld blank, %lld with the frame of the one before\n",
                                 static_cast<long long>(refreshes), in_words(refresh_hz).c_str(),
                                 static_cast<long long>(blank), static_cast<long long>(repeated));
    text += formatted("%lld frames sent, %lld lost, %lld late, %lld thinned, %lld shown; %lld cuts\n",
                      static_cast<long long>(frames_sent), static_cast<long long>(frames_lost),
                      static_cast<long long>(deliveries[Delivery::late]), static_cast<long long>(deliveries.thinned),
                      static_cast<long long>(frames_shown), static_cast<long long>(cuts));
    text += formatted("%-30s %9s %9s %9s %9s\n", "seen", "mean", "median", "p95", "max");
    const auto row = [&](const char* name, const Quantiles& spread, double scale) {
        text += formatted("%-30s %9.3f %9.3f %9.3f %9.3f\n", name, scale * spread.mean, scale * spread.median,
                          scale * spread.p95, scale * spread.max);
    };
    row("age, ms", age_ms, 1);
    row("carried on, ms", extrapolated_ms, 1);
    row("head off by, degrees", error_deg, 1);
    row("head off by, mm", error_m, 1e3);
    row("without reprojection, degrees", unreprojected_error_deg, 1);
    row("without reprojection, mm", unreprojected_error_m, 1e3);
    for (std::size_t i = 0; i < state_s.size(); ++i)
        if (state_s[i] > 0)
            text += formatted("%-12s %9.3f s\n", clock_state_names[i], state_s[i]);
    return text;
}

Json viewing_json(const ViewingReport& report, std::span<const ViewedRefresh> refreshes) {
    Json json = {{"refresh_hz", report.refresh_hz},
                 {"refreshes", report.refreshes},
                 {"blank", report.blank},
                 {"repeated", report.repeated},
                 {"frames_sent", report.frames_sent},
                 {"frames_lost", report.frames_lost},
                 {"frames_shown", report.frames_shown},
                 {"cuts", report.cuts}};
    for (std::size_t i = 0; i < delivery_count; ++i)
        json["deliveries"][delivery_names[i]] = report.deliveries.by[i];
    json["deliveries"]["thinned"] = report.deliveries.thinned;
    json["age_ms"] = quantiles_json(report.age_ms);
    json["carried_on_ms"] = quantiles_json(report.extrapolated_ms);
    json["error_deg"] = quantiles_json(report.error_deg);
    json["error_m"] = quantiles_json(report.error_m);
    json["unreprojected_error_deg"] = quantiles_json(report.unreprojected_error_deg);
    json["unreprojected_error_m"] = quantiles_json(report.unreprojected_error_m);
    for (std::size_t i = 0; i < clock_state_count; ++i)
        json["state_s"][clock_state_names[i]] = report.state_s[i];
    json["each"] = Json::array();
    for (const ViewedRefresh& refresh : refreshes)
        json["each"].push_back(refresh_json(refresh));
    return json;
}

}  // namespace equistream
