#include "delivery_window.h"

#include <algorithm>

namespace equistream {

namespace {

/// How long the highest rate and the shortest delay are remembered.
constexpr double fast_s = 1, short_s = 10;
/// A rate is taken over the time to an acknowledgement, and over this at least: they come every 10 ms.
constexpr double shortest_span_s = 0.03;
/// What has been lost and repaired is acknowledged that much later; what is later still waits in a queue.
constexpr double repaired_within_s = 0.2;
/// Between two calls; after a longer one the line was idle.
constexpr double longest_pause_s = 0.1;
/// Until it is known.
constexpr double first_delay_s = 0.1;
constexpr double gain = 2;
/// What was written itself waits in a queue, so that it is acknowledged later. Where nothing has been acknowledged as
/// soon for that long, the queue is emptied, for one such delay and this long, to see the line alone.
constexpr double drain_s = 0.1;
constexpr double min_bytes = 1 << 16, max_bytes = 1 << 23;

}  // namespace

void DeliveryWindow::add(double time_s, double written_bytes, double delivered_bytes, bool line_is_full) {
    if (written_.empty() || written_.back().value < written_bytes)
        written_.push_back({time_s, written_bytes});
    double written_at_s = -1;
    for (; !written_.empty() && written_.front().value <= delivered_bytes; written_.pop_front())
        written_at_s = written_.front().time_s;
    if (written_at_s >= 0 && written_at_s < time_s)
        see_delay(time_s, time_s - written_at_s);
    const bool is_queued =
        !written_.empty() && time_s - written_.front().time_s > 2 * acknowledged_after_s() + repaired_within_s;
    see_rate(time_s, delivered_bytes, (line_is_full || is_queued) && drains_until_s_ < 0);
}

void DeliveryWindow::see_rate(double time_s, double delivered_bytes, bool line_is_full) {
    if (!line_is_full)
        full_since_s_ = -1;
    else if (full_since_s_ < 0 || time_s - rate_at_s_ > longest_pause_s)
        full_since_s_ = time_s;
    rate_at_s_ = time_s;
    delivered_.push_back({time_s, delivered_bytes});
    const double span_s = std::max(shortest_span_s, acknowledged_after_s());
    while (delivered_.size() > 2 && delivered_[1].time_s <= time_s - span_s)
        delivered_.pop_front();
    const Sample& before = delivered_.front();
    if (time_s - before.time_s < shortest_span_s)
        return;
    const double rate = (delivered_bytes - before.value) / (time_s - before.time_s);
    // Where less was written than the line takes, a low rate says nothing of it.
    const bool is_the_lines = full_since_s_ >= 0 && before.time_s >= full_since_s_ + acknowledged_after_s();
    if (!is_the_lines && !fastest_.empty() && rate < fastest_.front().value)
        return;
    while (!fastest_.empty() && fastest_.back().value <= rate)
        fastest_.pop_back();
    fastest_.push_back({time_s, rate});
    while (fastest_.front().time_s < time_s - fast_s)
        fastest_.pop_front();
}

void DeliveryWindow::see_delay(double time_s, double delay_s) {
    if (shortest_s_ < 0 || delay_s <= shortest_s_) {
        shortest_s_ = delay_s;
        shortest_at_s_ = time_s;
        drains_until_s_ = -1;
    } else if (drains_until_s_ < 0 && time_s - shortest_at_s_ > short_s) {
        drains_until_s_ = time_s + delay_s + drain_s;
        drained_s_ = delay_s;
    } else if (drains_until_s_ >= 0) {
        drained_s_ = std::min(drained_s_, delay_s);
        if (time_s < drains_until_s_)
            return;
        shortest_s_ = drained_s_;
        shortest_at_s_ = time_s;
        drains_until_s_ = -1;
    }
}

double DeliveryWindow::acknowledged_after_s() const {
    return shortest_s_ < 0 ? first_delay_s : shortest_s_;
}

std::size_t DeliveryWindow::bytes() const {
    const bool drains = drains_until_s_ >= 0;
    return std::size_t(
        std::clamp(drains ? 0 : gain * bytes_per_second() * acknowledged_after_s(), min_bytes, max_bytes));
}

}  // namespace equistream
