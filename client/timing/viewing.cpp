#include "viewing.h"

namespace equistream {

namespace {

/// The head has been watched for so long when the first frame is sent.
constexpr double watched_before_s = 0.2;
constexpr double same_time_s = 1e-9;

}  // namespace

ViewingCourse::ViewingCourse(const NetworkConditions& network, const ViewingOptions& options, HeadPath head)
    : options_(options), head_(std::move(head)), network_(network), clock_(options.clock) {}

std::optional<double> ViewingCourse::send(const ServedFrame& frame) {
    if (sent_ == 0) {
        refresh_ = std::int64_t(std::ceil(frame.frame_time_s * options_.refresh_hz - same_time_s));
        tracked_ = std::int64_t(std::ceil((next_made_s() - watched_before_s) * options_.tracker_hz));
    }
    ++sent_;
    last_sent_s_ = frame.frame_time_s;
    const std::optional<double> arrival_s = network_.send(frame.frame_time_s, frame.bytes);
    lost_ += !arrival_s;
    return arrival_s;
}

ViewedRefresh ViewingCourse::begin_refresh() {
    const double made_s = next_made_s();
    for (; double(tracked_) / options_.tracker_hz <= made_s + same_time_s; ++tracked_)
        predictor_.seen(double(tracked_) / options_.tracker_hz, head_(double(tracked_) / options_.tracker_hz));
    time_ = clock_.at(made_s);
    ViewedRefresh refresh;
    refresh.number = refresh_;
    refresh.display_s = display_s();
    refresh.predicted_head = predictor_.predict(refresh.display_s);
    refresh.true_head = head_(refresh.display_s);
    if (time_) {
        refresh.rate = time_->rate;
        refresh.state = time_->state;
        is_over_ = time_->state == ClockState::ended;
    }
    ++refresh_;
    return refresh;
}

void ViewingCourse::add_figures(ViewingReport& report) const {
    report.frames_sent = sent_;
    report.frames_lost = lost_;
    report.cuts = clock_.cuts();
}

Viewing simulate_viewing(std::span<const ServedFrame> frames, const HeadPath& head, const NetworkConditions& network,
                         const ViewingOptions& options) {
    struct Nothing {};
    ViewingSimulation<Nothing> simulation(network, options, head);
    Viewing viewing;
    for (auto next = frames.begin();;) {
        while (simulation.needs_frame()) {
            if (next != frames.end())
                simulation.send(*next++, {});
            else
                simulation.end();
        }
        const std::optional<ViewedRefresh> refresh = simulation.next();
        if (!refresh)
            break;
        viewing.refreshes.push_back(*refresh);
    }
    viewing.report = report_viewing(viewing.refreshes, options.refresh_hz);
    simulation.add_figures(viewing.report);
    return viewing;
}

}  // namespace equistream
