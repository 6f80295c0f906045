#pragma once
/// A viewer of a late server, simulated, and what it saw.
#include "delivery_simulator.h"
#include "frame_slots.h"
#include "head_prediction.h"
#include "media_clock.h"

#include <nlohmann/json_fwd.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace equistream {

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

/// What does not depend on what frames hold.
class ViewingCourse {
public:
    ViewingCourse(const NetworkConditions& network, const ViewingOptions& options, HeadPath head);

    /// Sent after all that were before: when it arrives, if ever.
    std::optional<double> send(const ServedFrame& frame);
    bool has_sent() const { return sent_ > 0; }
    /// When the next refresh is made.
    double next_made_s() const { return display_s() - options_.photon_s; }
    /// Nothing sent from now on arrives earlier.
    double earliest_arrival_s() const { return network_.earliest_arrival_s(last_sent_s_); }

    void arrived(const FrameStamp& stamp) { clock_.arrived(stamp.frame_time_s, stamp.arrival_s); }
    void end() { clock_.end(); }
    /// All of the next refresh but its frames.
    ViewedRefresh begin_refresh();
    /// What it is to show; nothing: nothing has come.
    const std::optional<MediaTime>& time() const { return time_; }
    bool is_over() const { return is_over_; }
    /// Of the clock, for what moves. As the clock runs, and as display time does, this goes on without a step: what is
    /// extrapolated by it neither jumps when frames stay away nor when they come again.
    double ahead_s(double display_s) const {
        return std::clamp(display_s - time_->frame_time_s, 0.0, options_.extrapolation_limit_s);
    }
    void add_figures(ViewingReport& report) const;

private:
    double display_s() const { return double(refresh_) / options_.refresh_hz; }

    ViewingOptions options_;
    HeadPath head_;
    DeliverySimulator network_;
    MediaClock clock_;
    HeadPredictor predictor_;
    std::optional<MediaTime> time_;
    std::int64_t refresh_ = 0, tracked_ = 0;
    std::int64_t sent_ = 0, lost_ = 0;
    double last_sent_s_ = 0;
    bool is_over_ = false;
};

/// With payloads that go from send() to shown(). In play order:
///     while (viewing.needs_frame()) send the next one, or end();
///     refresh = viewing.next();
template <typename Payload>
class ViewingSimulation {
public:
    ViewingSimulation(const NetworkConditions& network, const ViewingOptions& options, HeadPath head)
        : course_(network, options, std::move(head)), ring_(options.ring) {}

    /// Whether a frame that was not sent yet might be there for the next refresh.
    bool needs_frame() const {
        return !ended_ && (!course_.has_sent() || course_.earliest_arrival_s() <= course_.next_made_s());
    }
    /// In the order of their times.
    void send(const ServedFrame& frame, Payload payload) {
        if (const std::optional<double> arrival_s = course_.send(frame))
            under_way_.push_back({{frame.number, frame.frame_time_s, frame.head, *arrival_s}, std::move(payload)});
    }
    /// There are no more.
    void end() { ended_ = true; }

    /// The next refresh; nothing once the last frame that came has been seen.
    std::optional<ViewedRefresh> next() {
        if (course_.is_over() || !course_.has_sent())
            return std::nullopt;
        deliver_until(course_.next_made_s());
        if (ended_ && under_way_.empty()) {
            course_.end();
            if (!delivered_any_)
                return std::nullopt;
        }
        ViewedRefresh refresh = course_.begin_refresh();
        if (!course_.time())
            return refresh;
        const auto frames = ring_.show(course_.time()->frame_time_s);
        if (frames.empty())
            return refresh;
        shown_ = &frames[0].payload();
        refresh.frame = frames[0].stamp();
        refresh.extrapolated_s = course_.time()->frame_time_s - refresh.frame->frame_time_s;
        refresh.ahead_s = course_.ahead_s(refresh.display_s);
        if (frames.size() > 1)
            refresh.previous = frames[1].stamp();
        return refresh;
    }
    /// What the last refresh that has a frame shows.
    Payload& shown() const { return *shown_; }

    /// As far as it is not of the refreshes.
    void add_figures(ViewingReport& report) const {
        course_.add_figures(report);
        report.deliveries = ring_.counts();
    }

private:
    struct UnderWay {
        FrameStamp stamp;
        Payload payload;
    };

    void deliver_until(double time_s) {
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
                course_.arrived(*arrival);
        }
    }

    ViewingCourse course_;
    FrameRing<Payload> ring_;
    std::vector<UnderWay> under_way_;
    Payload* shown_ = nullptr;
    bool ended_ = false, delivered_any_ = false;
};

struct Viewing {
    std::vector<ViewedRefresh> refreshes;
    ViewingReport report;
};

/// A whole run from a list of frames, in the order of their times.
Viewing simulate_viewing(std::span<const ServedFrame> frames, const HeadPath& head, const NetworkConditions& network,
                         const ViewingOptions& options = {});

}  // namespace equistream
