#include "delivery_simulator.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace equistream {

namespace {

/// SplitMix64 (Steele et al. 2014, "Fast splittable pseudorandom number generators"), a step and its output.
std::uint64_t mixed(std::uint64_t state) {
    state += 0x9e3779b97f4a7c15;
    state = (state ^ state >> 30) * 0xbf58476d1ce4e5b9;
    state = (state ^ state >> 27) * 0x94d049bb133111eb;
    return state ^ state >> 31;
}

/// What a number is drawn for.
constexpr std::uint64_t of_jitter = 0, of_loss = 1;

}  // namespace

DeliverySimulator::DeliverySimulator(NetworkConditions conditions)
    : conditions_(std::move(conditions)), link_free_s_(-std::numeric_limits<double>::infinity()),
      last_arrival_s_(-std::numeric_limits<double>::infinity()) {
    std::ranges::sort(conditions_.stalls, {}, &NetworkStall::at_s);
}

/// From 0 to below 1.
double DeliverySimulator::uniform(std::uint64_t what, std::uint64_t which) const {
    return double(mixed(mixed(mixed(mixed(conditions_.seed) + frame_) + what) + which) >> 11) * 0x1p-53;
}

/// When something that takes `sending_s` to send, and may begin at `from_s`, has left.
double DeliverySimulator::leaves_s(double from_s, double sending_s) const {
    for (const NetworkStall& stall : conditions_.stalls) {
        if (stall.at_s + stall.lasts_s <= from_s)
            continue;
        if (from_s + sending_s < stall.at_s)
            break;
        sending_s -= std::max(0.0, stall.at_s - from_s);
        from_s = stall.at_s + stall.lasts_s;
    }
    return from_s + sending_s;
}

/// How often the unluckiest of a frame's packets is lost.
int DeliverySimulator::max_losses(std::int64_t packets) const {
    if (conditions_.loss <= 0)
        return 0;
    int most = 0;
    std::uint64_t draw = 0;
    for (std::int64_t packet = 0; packet < packets; ++packet) {
        int losses = 0;
        while (uniform(of_loss, draw++) < conditions_.loss)
            ++losses;
        most = std::max(most, losses);
    }
    return most;
}

std::optional<double> DeliverySimulator::send(double sent_s, std::int64_t bytes) {
    const std::int64_t packets = std::max<std::int64_t>(1, (bytes + packet_bytes - 1) / packet_bytes);
    const double sending_s = conditions_.bandwidth_bps > 0 ? double(bytes) * 8 / conditions_.bandwidth_bps : 0;
    link_free_s_ = leaves_s(std::max(sent_s, link_free_s_), sending_s);
    double arrival_s = link_free_s_ + conditions_.delay_s + conditions_.jitter_s * uniform(of_jitter, 0);
    const int losses = max_losses(packets);
    ++frame_;
    if (conditions_.datagrams)
        return losses == 0 ? std::optional(arrival_s) : std::nullopt;
    arrival_s += losses * std::max(2 * conditions_.delay_s, shortest_round_trip_s);
    last_arrival_s_ = std::max(arrival_s, last_arrival_s_);
    return last_arrival_s_;
}

double DeliverySimulator::earliest_arrival_s(double sent_s) const {
    const double alone_s = leaves_s(std::max(sent_s, link_free_s_), 0) + conditions_.delay_s;
    return conditions_.datagrams ? alone_s : std::max(alone_s, last_arrival_s_);
}

std::vector<std::optional<double>> simulate_delivery(const NetworkConditions& conditions,
                                                     std::span<const SentFrame> frames) {
    DeliverySimulator simulator(conditions);
    std::vector<std::optional<double>> arrivals;
    arrivals.reserve(frames.size());
    for (const SentFrame& frame : frames)
        arrivals.push_back(simulator.send(frame.sent_s, frame.bytes));
    return arrivals;
}

}  // namespace equistream
