#include "rate.h"

#include <equistream/window.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace equistream::serve {

namespace {

/// Rates are of so long, or of two spheres where these take longer.
constexpr double watched_s = 1;
/// A viewer that is so far behind has a line that carries less than it is sent.
constexpr double behind_is_too_much_s = 0.25;
/// Of what a line carries while it is full: what waits must become less.
constexpr double share_used = 0.8;
/// By which a line that is not full is tried again with more, a second.
constexpr double growth_per_s = 1.4;
/// Noise takes most bytes, and none at all once it is coded away: what one sphere took says little of a finer one.
constexpr double steps_finer_per_s = 4;
/// What a key frame takes more than others, so many spheres after it give up between them.
constexpr double made_up_by = 10;
/// Lines that carry less are not told apart.
constexpr double min_bps = 1e4;
/// The window gives up so much before the sphere around it gives up anything.
constexpr double window_first = 12;
/// From this CRF on, a window of half the pixels and as many bytes looks better (docs/decisions/0018).
constexpr double crf_to_halve_at = 34;
/// No way back within so many steps of where it was decided, and only after so long. Then CRF alone makes up for the
/// key frame, as long again.
constexpr double steps_of_hysteresis = 3;
constexpr double longing_s = 10;

}  // namespace

void RateControl::coded(double at_s, std::size_t bytes, double coarser, bool begins_group) {
    double bits = 8.0 * double(bytes) * std::exp2(coarser / steps_that_halve);
    const double made_up_for = key_excess_bits_ / made_up_by;
    key_excess_bits_ -= made_up_for;
    if (begins_group && !spheres_.empty()) {
        const double usual = std::min(bits, spheres_.back().bits);
        key_excess_bits_ += bits - usual;
        bits = usual;
    }
    spheres_.push_back({at_s, bits + made_up_for});
    while (spheres_.size() > 3 && spheres_.front().at_s < at_s - watched_s)
        spheres_.pop_front();
    choose(at_s);
}

/// What arrived between the oldest look that is remembered and the last one that found more. A line that stands
/// still for a moment says nothing of what it carries: nothing.
std::optional<double> RateControl::carried_bps() const {
    const auto moved = std::ranges::find_if(sent_, [&](const Sent& s) { return s.bytes > sent_.front().bytes; });
    if (moved == sent_.end())
        return std::nullopt;
    const auto last = std::ranges::find(sent_, sent_.back().bytes, &Sent::bytes);
    auto oldest = sent_.begin();
    // The look that finds a line moving again after it stood still may have had a moment of that alone.
    if (sent_[1].bytes == oldest->bytes) {
        if (last != moved)
            oldest = moved;
        else if (std::next(moved) == sent_.end())
            return std::nullopt;
    }
    return 8.0 * double(last->bytes - oldest->bytes) / std::max(1e-3, last->at_s - oldest->at_s);
}

void RateControl::delivered(double at_s, int viewer, const Delivery& delivery) {
    if (viewer != viewer_) {
        viewer_ = viewer;
        sent_.clear();
        line_bps_.reset();
        if (!max_bps_)
            coarser_ = 0;
    }
    sent_.push_back({at_s, delivery.bytes_arrived});
    while (sent_.size() > 2 && sent_[1].at_s <= at_s - watched_s)
        sent_.pop_front();
    const double elapsed_s = at_s - std::exchange(line_changed_s_, at_s);
    if (delivery.behind_s > behind_is_too_much_s) {
        if (const std::optional<double> carried = carried_bps())
            line_bps_ = std::max(min_bps, share_used * *carried);
    } else if (line_bps_ && delivery.behind_s == 0) {
        line_bps_ = *line_bps_ * std::pow(growth_per_s, std::min(elapsed_s, watched_s));
    }
    choose(at_s);
}

void RateControl::pause() {
    spheres_.clear();
    key_excess_bits_ = 0;
    sent_.clear();
}

void RateControl::choose(double at_s) {
    const double elapsed_s = at_s - std::exchange(chosen_s_, at_s);
    if (spheres_.size() < 2)
        return;
    double wanted_bits = 0;
    for (std::size_t i = 1; i < spheres_.size(); ++i)
        wanted_bits += spheres_[i].bits;
    const double wanted_bps = wanted_bits / std::max(1e-3, spheres_.back().at_s - spheres_.front().at_s);
    // A line that carries all there is need not be watched any more.
    if (line_bps_ && *line_bps_ > 1.5 * wanted_bps)
        line_bps_.reset();
    limit_bps_ = std::max(min_bps, std::min(max_bps_.value_or(wanted_bps), line_bps_.value_or(wanted_bps)));
    const double enough = std::clamp(steps_that_halve * std::log2(wanted_bps / limit_bps_), 0.0, coarsest);
    coarser_ = std::max(enough, coarser_ - steps_finer_per_s * elapsed_s);
}

int WindowHalvings::next(double at_s, double coarser) {
    const auto left = [&] { return coarser - steps_that_halve * halvings_; };  // for CRF to give
    const bool has_settled = !given_back_s_ || at_s - *given_back_s_ >= longing_s;
    while (has_settled && halvings_ < most_window_halvings && crf_ + left() > crf_to_halve_at &&
           left() >= steps_that_halve + steps_of_hysteresis)
        ++halvings_;
    const bool fewer_would_do =
        halvings_ > 0 && (left() < 0 || crf_ + left() + steps_that_halve < crf_to_halve_at - steps_of_hysteresis);
    if (!fewer_would_do) {
        fewer_since_s_.reset();
    } else if (at_s - fewer_since_s_.value_or(at_s) >= longing_s) {
        --halvings_;
        given_back_s_ = at_s;
        fewer_since_s_.reset();
    } else if (!fewer_since_s_) {
        fewer_since_s_ = at_s;
    }
    return halvings_;
}

CoarserParts divided(double coarser, bool has_window) {
    if (!has_window)
        return {.window = 0, .base = coarser};
    return {.window = coarser, .base = std::max(0.0, coarser - window_first)};
}

}  // namespace equistream::serve
