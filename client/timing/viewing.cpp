#include "viewing.h"

#include <equistream/conventions.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace equistream {

namespace {

/// The head has been watched for so long when the first frame is sent.
constexpr double watched_before_s = 0.2;
constexpr double same_time_s = 1e-9;
/// Times of frames that refreshes can be counted by.
constexpr double farthest_s = 1e10;
/// No path of a head is longer, so that a longer step is damage: every refresh in it would be shown.
constexpr double longest_step_s = 86400;

using Json = nlohmann::ordered_json;

double degrees_between(const glm::dquat& a, const glm::dquat& b) {
    const glm::dquat turn = glm::conjugate(a) * b;
    return 2 * std::atan2(glm::length(glm::dvec3(turn.x, turn.y, turn.z)), std::abs(turn.w)) * 180 / pi;
}

Json quantiles_json(const Quantiles& spread) {
    return {{"mean", spread.mean},
            {"median", spread.median},
            {"p95", spread.p95},
            {"p99", spread.p99},
            {"max", spread.max}};
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
    json["extrapolated_ms"] = 1e3 * refresh.extrapolated_s;
    json["ahead_ms"] = 1e3 * refresh.ahead_s;
    json["error_deg"] = refresh.error_deg();
    json["error_m"] = refresh.error_m();
    json["unreprojected_error_deg"] = refresh.unreprojected_error_deg();
    json["unreprojected_error_m"] = refresh.unreprojected_error_m();
    return json;
}

}  // namespace

ViewingSimulation::ViewingSimulation(const NetworkConditions& network, const ViewingOptions& options, HeadPath head)
    : options_(options), head_(std::move(head)), network_(network), clock_(options.clock), ring_(options.ring) {}

bool ViewingSimulation::needs_frame() const {
    return !ended_ && (sent_ == 0 || network_.earliest_arrival_s(last_sent_s_) <= next_made_s());
}

void ViewingSimulation::require_next_time(const ServedFrame& frame) const {
    const std::string place = formatted("frame %lld", static_cast<long long>(frame.number));
    if (!(std::abs(frame.frame_time_s) <= farthest_s))
        throw InputError(expected_found(place, formatted("a time from %g to %g s", -farthest_s, farthest_s),
                                        formatted("%.17g s", frame.frame_time_s)));
    const double step_s = frame.frame_time_s - last_sent_s_;
    if (sent_ > 0 && !(step_s >= 0 && step_s <= longest_step_s))
        throw InputError(expected_found(place, "a time from that of the frame before to a day later",
                                        formatted("%.17g s after %.17g s", frame.frame_time_s, last_sent_s_)));
}

/// Every refresh until then would be shown. Where the frame is lost, the next one is waited for.
void ViewingSimulation::require_near_arrival(const ServedFrame& frame, const std::optional<double>& arrival_s) const {
    const double due_s = arrival_s ? *arrival_s : network_.earliest_arrival_s(frame.frame_time_s);
    if (!(std::abs(due_s - frame.frame_time_s) <= longest_step_s))
        throw InputError(
            expected_found(formatted("--network: frame %lld", static_cast<long long>(frame.number)),
                           std::string(arrival_s ? "an arrival" : "the next frame's arrival, since this one is lost,") +
                               " within a day of " + in_words(frame.frame_time_s) + " s, its own time",
                           in_words(due_s) + " s"));
}

void ViewingSimulation::send(const ServedFrame& frame, Payload payload) {
    require_next_time(frame);
    if (sent_ == 0) {
        refresh_ = std::int64_t(std::ceil(frame.frame_time_s * options_.refresh_hz - same_time_s));
        tracked_ = std::int64_t(std::ceil((next_made_s() - watched_before_s) * options_.tracker_hz));
    }
    ++sent_;
    last_sent_s_ = frame.frame_time_s;
    const std::optional<double> arrival_s = network_.send(frame.frame_time_s, frame.bytes);
    require_near_arrival(frame, arrival_s);
    if (arrival_s)
        under_way_.push_back({{frame.number, frame.frame_time_s, frame.head, *arrival_s}, std::move(payload)});
    else
        ++lost_;
}

void ViewingSimulation::deliver_until(double time_s) {
    for (;;) {
        const auto first =
            std::ranges::min_element(under_way_, {}, [](const UnderWay& frame) { return frame.stamp.arrival_s; });
        if (first == under_way_.end() || first->stamp.arrival_s > time_s)
            return;
        ring_.writable() = std::move(first->payload);
        ring_.deliver(first->stamp);
        delivered_any_ = true;
        under_way_.erase(first);
        while (const std::optional<FrameStamp> arrival = ring_.next_arrival())
            clock_.arrived(arrival->frame_time_s, arrival->arrival_s);
    }
}

/// All of it but what it shows.
ViewedRefresh ViewingSimulation::begin_refresh() {
    for (; double(tracked_) / options_.tracker_hz <= next_made_s() + same_time_s; ++tracked_)
        predictor_.seen(double(tracked_) / options_.tracker_hz, head_(double(tracked_) / options_.tracker_hz));
    ViewedRefresh refresh;
    refresh.number = refresh_;
    refresh.display_s = display_s();
    refresh.predicted_head = predictor_.predict(refresh.display_s);
    refresh.true_head = head_(refresh.display_s);
    return refresh;
}

void ViewingSimulation::show(const MediaTime& time, ViewedRefresh& refresh) {
    refresh.rate = time.rate;
    refresh.state = time.state;
    is_over_ = time.state == ClockState::ended;
    const auto slots = ring_.show(time.frame_time_s);
    if (slots.empty())
        return;
    shown_ = ring_.payload(slots[0]);
    refresh.frame = ring_.stamp(slots[0]);
    refresh.extrapolated_s = time.frame_time_s - refresh.frame->frame_time_s;
    // As the clock runs, and as display time does, this goes on without a step: what is extrapolated by it neither
    // jumps when frames stay away nor when they come again.
    refresh.ahead_s = std::clamp(refresh.display_s - time.frame_time_s, 0.0, options_.extrapolation_limit_s);
    if (slots.size() > 1)
        refresh.previous = ring_.stamp(slots[1]);
}

std::optional<ViewedRefresh> ViewingSimulation::next() {
    if (is_over_ || sent_ == 0)
        return std::nullopt;
    deliver_until(next_made_s());
    if (ended_ && under_way_.empty()) {
        clock_.end();
        if (!delivered_any_)
            return std::nullopt;
    }
    ViewedRefresh refresh = begin_refresh();
    if (const std::optional<MediaTime> time = clock_.at(next_made_s()))
        show(*time, refresh);
    ++refresh_;
    return refresh;
}

void ViewingSimulation::add_figures(ViewingReport& report) const {
    report.frames_sent = sent_;
    report.frames_lost = lost_;
    report.cuts = clock_.cuts();
    report.deliveries = ring_.counts();
}

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
            ranked(0.99), values.back()};
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
    std::string text =
        formatted("%lld refreshes at %s Hz: %lld blank, %lld that repeat a frame\n", static_cast<long long>(refreshes),
                  in_words(refresh_hz).c_str(), static_cast<long long>(blank), static_cast<long long>(repeated));
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
    row("extrapolated, ms", extrapolated_ms, 1);
    row("head error, degrees", error_deg, 1);
    row("head error, mm", error_m, 1e3);
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
    json["extrapolated_ms"] = quantiles_json(report.extrapolated_ms);
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
