#include "media_clock.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace equistream {

namespace {

constexpr double still_rate = 0.05;
/// Behind by more than the first begins to catch up, by less than the second has.
constexpr double catch_up_s = 0.3, level_s = 0.05;
constexpr double same_time_s = 1e-6;
/// Fewer frames than that are too few to forget any.
constexpr std::size_t fewest_samples = 16;

/// How far a rate of `steady` gets in `elapsed_s` where it may never exceed room / tau: steady until that binds, from
/// then on exponentially towards the end of the room.
double advance_within(double room_s, double tau_s, double steady, double elapsed_s) {
    if (room_s <= 0 || steady <= 0)
        return 0;
    const double free_s = std::max(0.0, room_s / steady - tau_s);  // until it binds
    if (elapsed_s <= free_s)
        return steady * elapsed_s;
    const double room_then_s = room_s - steady * free_s;
    return steady * free_s + room_then_s * -std::expm1(-(elapsed_s - free_s) / tau_s);
}

}  // namespace

MediaClock::MediaClock(const MediaClockOptions& options) : options_(options), playout_delay_s_(options.start_delay_s) {
    assert(options.start_frames <= media_clock_window);
}

void MediaClock::arrived(double frame_time_s, double arrival_s) {
    if (sample_count_ == 0)
        first_s_ = newest_s_ = frame_time_s;
    const double since_last_s = frame_time_s - newest_s_;
    newest_s_ = std::max(newest_s_, frame_time_s);
    samples_[sample_count_ % media_clock_window] = {arrival_s - frame_time_s, arrival_s, since_last_s};
    ++sample_count_;
    estimate();
}

void MediaClock::estimate() {
    const std::size_t known = std::min(sample_count_, media_clock_window);
    std::array<double, media_clock_window> values{};
    std::size_t count = 0;
    const double now_s = samples_[(sample_count_ - 1) % media_clock_window].arrival_s;
    const auto sample = [&](std::size_t age) -> const Sample& {
        return samples_[(sample_count_ - 1 - age) % media_clock_window];
    };
    std::size_t recent = known;
    while (recent > fewest_samples && now_s - sample(recent - 1).arrival_s > options_.window_s)
        --recent;

    path_delay_s_ = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < recent; ++i)
        path_delay_s_ = std::min(path_delay_s_, sample(i).offset_s);
    // A stall's frames are no jitter, nor are the last ones that it held back, which are less late but came with them.
    bool stalled = false;
    double before_s = 0;
    for (std::size_t i = recent; i-- > 0;) {
        const double excess_s = sample(i).offset_s - path_delay_s_;
        stalled = excess_s > options_.max_delay_s || (stalled && sample(i).arrival_s - before_s < interval_s_ / 2);
        before_s = sample(i).arrival_s;
        if (!stalled)
            values[count++] = excess_s;
    }
    if (count == 0)
        values[count++] = 0;  // all is one stall's
    std::sort(values.begin(), values.begin() + std::ptrdiff_t(count));
    const auto takes = [&](double share) {
        return values[std::clamp<std::size_t>(std::size_t(std::ceil(share * double(count))), 1, count) - 1];
    };
    playout_delay_s_ = std::max(options_.min_delay_s, takes(options_.on_time_share));
    usually_late_s_ = std::max(0.0, takes(options_.usual_share) - playout_delay_s_);
    if (sample_count_ < options_.start_frames)
        playout_delay_s_ = std::max(playout_delay_s_, options_.start_delay_s);

    count = 0;
    for (std::size_t i = 0; i < recent; ++i)
        if (sample(i).since_last_s > 0)
            values[count++] = sample(i).since_last_s;
    if (count > 0) {
        const auto median = values.begin() + std::ptrdiff_t(count / 2);
        std::nth_element(values.begin(), median, values.begin() + std::ptrdiff_t(count));
        interval_s_ = *median;
    }
}

double MediaClock::advance_s(double display_s, double elapsed_s) {
    if (ended_)
        return std::clamp(elapsed_s, 0.0, std::max(0.0, newest_s_ - shown_s_));
    const double behind_s = aim_s(display_s) - elapsed_s - shown_s_;
    const double towards_s = elapsed_s + behind_s * -std::expm1(-elapsed_s / options_.settle_s);
    const double fastest = std::min(options_.max_rate, rate_ + options_.max_rate_rise_per_s * elapsed_s);
    const double steady = std::min(std::max(towards_s / elapsed_s, options_.min_rate), fastest);
    const double room_s = newest_s_ + interval_s_ + usually_late_s_ + options_.overrun_s - shown_s_;
    return advance_within(room_s, options_.overrun_s, steady, elapsed_s);
}

ClockState MediaClock::state(double display_s) {
    if (ended_ && shown_s_ >= newest_s_ - same_time_s)
        return ClockState::ended;
    if (!moving_)
        return ClockState::starting;
    // Level with what came is as level as it gets.
    const double behind_s = std::min(aim_s(display_s), newest_s_) - shown_s_;
    catching_up_ = behind_s > (catching_up_ ? level_s : catch_up_s);
    if (catching_up_)
        return ClockState::catching_up;
    if (shown_s_ <= newest_s_ + interval_s_ + same_time_s)
        return ClockState::playing;
    return rate_ < still_rate ? ClockState::stalled : ClockState::late;
}

std::optional<MediaTime> MediaClock::at(double display_s) {
    if (sample_count_ == 0)
        return std::nullopt;
    const double elapsed_s = was_asked_ ? display_s - display_s_ : 0;
    assert(elapsed_s >= 0);
    display_s_ = display_s;
    if (!was_asked_) {
        was_asked_ = true;
        shown_s_ = first_s_;
    }
    if (!moving_)
        moving_ = aim_s(display_s) > first_s_ || ended_;
    const double goal_s = std::min(aim_s(display_s), newest_s_);
    if (moving_ && (elapsed_s > options_.pause_s || goal_s - shown_s_ > options_.skip_behind_s)) {
        if (goal_s > shown_s_) {
            shown_s_ = goal_s;
            ++cuts_;
        }
        rate_ = 1;
    } else if (moving_ && elapsed_s > 0) {
        const double advance = advance_s(display_s, elapsed_s);
        rate_ = advance / elapsed_s;
        shown_s_ += advance;
    }
    return MediaTime{shown_s_, rate_, state(display_s)};
}

}  // namespace equistream
