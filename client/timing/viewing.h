#pragma once
/// A viewer of a late server, simulated, and what it saw.
#include "delivery_simulator.h"
#include "frame_slots.h"
#include "head_prediction.h"
#include "media_clock.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

struct ReceivedFrame;

// What the eye saw, refresh by refresh, and in sum.

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
    double mean = 0, median = 0, p95 = 0, p99 = 0, max = 0;
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

// A viewer of a late server, simulated: frames go through a network that does not exist (delivery_simulator.h) into
// the ring, the clock and the prediction of a live player, and come out at the refreshes of a display that does
// not exist either. One clock for all: a frame is sent at its frame time, and the head's path and the stalls count on
// it too. Refresh k is seen at k / refresh_hz, and made photon_s before that, of what has come and of how the head has
// moved by then.

struct ViewingOptions {
    double refresh_hz = 90;
    double photon_s = 0.02;   ///< from the last look at the head to the middle of the refresh
    double tracker_hz = 500;  ///< poses of the head
    double extrapolation_limit_s =
        0;  ///< what moves by itself is shown up to so much ahead of the clock: where it is by now
    MediaClockOptions clock{};
    FrameRingOptions ring{};
};

struct ServedFrame {
    std::int64_t number = 0;
    double frame_time_s = 0;
    Pose head;  ///< that it was made for
    std::int64_t bytes = 0;
};

/// Where the head is at a time.
using HeadPath = std::function<Pose(double time_s)>;

/// In play order:
///     while (viewing.needs_frame()) send the next one, or end();
///     refresh = viewing.next();
class ViewingSimulation {
public:
    /// What goes from send() to shown().
    using Payload = std::shared_ptr<ReceivedFrame>;

    ViewingSimulation(const NetworkConditions& network, const ViewingOptions& options, HeadPath head);

    /// Whether a frame that was not sent yet might be there for the next refresh.
    bool needs_frame() const;
    /// In the order of their times. Throws InputError for a time before the last one, more than a day after it, or
    /// beyond 1e10 s, and for an arrival more than a day off the frame's time. Of a lost frame the next arrival counts.
    void send(const ServedFrame& frame, Payload payload);
    /// There are no more.
    void end() { ended_ = true; }

    /// The next refresh; nothing once the last frame that came has been seen.
    std::optional<ViewedRefresh> next();
    /// What the last refresh that has a frame shows.
    const Payload& shown() const { return shown_; }

    /// As far as it is not of the refreshes.
    void add_figures(ViewingReport& report) const;

private:
    struct UnderWay {
        FrameStamp stamp;
        Payload payload;
    };

    double display_s() const { return double(refresh_) / options_.refresh_hz; }
    /// When the next refresh is made.
    double next_made_s() const { return display_s() - options_.photon_s; }
    void require_next_time(const ServedFrame& frame) const;
    void require_near_arrival(const ServedFrame& frame, const std::optional<double>& arrival_s) const;
    void deliver_until(double time_s);
    ViewedRefresh begin_refresh();
    void show(const MediaTime& time, ViewedRefresh& refresh);

    ViewingOptions options_;
    HeadPath head_;
    DeliverySimulator network_;
    MediaClock clock_;
    HeadPredictor predictor_;
    FrameRing<Payload> ring_;
    std::vector<UnderWay> under_way_;
    Payload shown_;
    std::int64_t refresh_ = 0, tracked_ = 0;
    std::int64_t sent_ = 0, lost_ = 0;
    double last_sent_s_ = 0;
    bool ended_ = false, delivered_any_ = false, is_over_ = false;
};

struct Viewing {
    std::vector<ViewedRefresh> refreshes;
    ViewingReport report;
};

}  // namespace equistream
