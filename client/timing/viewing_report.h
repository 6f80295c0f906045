#pragma once
/// What the eye saw, refresh by refresh, and in sum.
#include "frame_slots.h"
#include "media_clock.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// One refresh of the display.
struct ViewedRefresh {
    std::int64_t number = 0;             ///< seen at number / refreshes per second
    double display_s = 0;                ///< on the clock of the frames' times
    Pose predicted_head, true_head;      ///< for that moment: as foretold when the refresh was made, and as it was then
    std::optional<FrameStamp> frame;     ///< shown; nothing: none had come
    std::optional<FrameStamp> previous;  ///< the newest before it that is still there to fill from
    double extrapolated_s = 0;           ///< by which moving objects are later than in the frame
    double ahead_s = 0;                  ///< and by which they may be later still, to be where they are by now
    double rate = 0;                     ///< of the frames' time
    ClockState state = ClockState::starting;

    /// By which moving objects are later than in the frame where they are extrapolated.
    double extrapolation_s() const { return extrapolated_s + ahead_s; }
    /// Of what is seen.
    double age_s() const { return display_s - frame->frame_time_s; }
    double error_deg() const;
    double error_m() const;
    /// Had the frame been shown as it came, for the head that it was made for: a plain remote renderer.
    double unreprojected_error_deg() const;
    double unreprojected_error_m() const;
};

/// Of a figure over refreshes; percentiles are nearest ranks.
struct Quantiles {
    double mean = 0, median = 0, p95 = 0, max = 0;
};
Quantiles quantiles_of(std::vector<double> values);

struct ViewingReport {
    double refresh_hz = 0;
    std::int64_t refreshes = 0;
    std::int64_t blank = 0;     ///< of them, before anything could be shown
    std::int64_t repeated = 0;  ///< of them, with the frame of the refresh before
    std::int64_t frames_shown = 0;
    std::int64_t frames_sent = 0, frames_lost = 0, cuts = 0;
    DeliveryCounts deliveries;
    Quantiles age_ms, extrapolated_ms;  ///< these and the following of refreshes that are not blank
    Quantiles error_deg, error_m;
    Quantiles unreprojected_error_deg, unreprojected_error_m;
    std::array<double, clock_state_count> state_s{};  ///< by ClockState

    std::string table() const;
};

/// All but what is not of the refreshes: frames_sent, frames_lost, cuts, deliveries.
ViewingReport report_viewing(std::span<const ViewedRefresh> refreshes, double refresh_hz);

/// Every refresh under "each"; keys are those of the structures.
nlohmann::ordered_json viewing_json(const ViewingReport& report, std::span<const ViewedRefresh> refreshes);

}  // namespace equistream
