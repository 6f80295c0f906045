#include "playback.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace equistream {

/// After a pause of the whole program (a debugger, a closed lid) a recorded source goes on from where it was.
constexpr double longest_step_s = 0.25;

/// Clocks and frame times are sums of doubles.
constexpr double same_time_s = 1e-6;

/// Of the time between two frames: a frame that comes so little before the time that is sought is the one.
constexpr double same_frame = 0.01;

/// Over which jitter is averaged.
constexpr double jitter_frames = 16;

/// Time constant with which the path's delay is followed, as the clock follows the play-out delay.
constexpr double settle_s = MediaClockOptions{}.settle_s;

/// Nothing of a recorded source comes late.
constexpr MediaClockOptions recorded_options{.start_delay_s = 0, .start_frames = 1};

Playback::Playback(FrameLoader& loader, bool paused) : loader_(loader), paused_(paused) {
    time_s_ = loader.first().time_s;
}

double Playback::interval_s() const {
    return 1 / loader_.first().frames_per_second;
}

double Playback::overdue_s() const {
    if (!is_live() || !now_s_ || !clock_runs_ || has_ended_)
        return 0;
    const double overdue_s = std::max(0.0, *now_s_ - newest_arrival_s_ - clock_.frame_interval_s());
    const bool is_late = is_moving() ? state_ == ClockState::late || state_ == ClockState::stalled
                                     : overdue_s > clock_.playout_delay_s();  // the clock is not asked then
    return is_late ? overdue_s : 0;
}

void Playback::play() {
    if (over_ && is_live()) {
        loader_.seek(loader_.first().index);
        forget_reel();
    } else if (over_ && !can_jump()) {
        return;
    } else if (over_) {
        seek(loader_.first().time_s);
    }
    paused_ = false;
}

/// Of the first frame that is not before this time, if none is missing.
std::int64_t Playback::number_at(double time_s) const {
    const FrameInfo& first = loader_.first();
    const double frames = std::max(0.0, time_s - first.time_s) * first.frames_per_second;
    return first.index + std::int64_t(std::ceil(std::min(frames - same_frame, double(max_frame_index))));
}

void Playback::seek(double time_s) {
    jump(time_s, number_at(time_s), {});
}

void Playback::seek_back(double time_s) {
    if (last_shown_)
        jump(time_s, std::max(loader_.first().index, std::min(number_at(time_s), last_shown_->number - 1)),
             last_shown_->frame_time_s);
    else
        seek(time_s);
}

void Playback::jump(double time_s, std::int64_t number, std::optional<double> before_s) {
    if (!can_jump())
        return;
    time_s_ = std::max(time_s, loader_.first().time_s);
    loader_.seek(number, before_s);
    forget_reel();
}

double Playback::time_on_s(double from_s, double by_s, double seconds) const {
    const double last_s = loader_.first().time_s + seconds - interval_s(), rounding_s = interval_s() / 2;
    const bool is_known = seconds > 0 && from_s <= last_s + rounding_s;
    return is_known ? std::max(from_s, std::min(from_s + by_s, last_s - rounding_s)) : from_s + by_s;
}

void Playback::forget_reel() {
    reel_ = nullptr;
    waiting_.clear();
    clock_ = MediaClock(is_live() ? MediaClockOptions{} : recorded_options);
    clock_runs_ = over_ = false;
    path_delay_s_.reset();
    behind_s_ = 0;
    last_arrival_.reset();
    came_.clear();
    stepping_ = true;
    shown_number_ = -1;
    shown_s_ = 0;
}

void Playback::take_arrivals() {
    while (const std::optional<FrameStamp> stamp = reel_->next_arrival()) {
        newest_s_ = clock_runs_ ? std::max(newest_s_, stamp->frame_time_s) : stamp->frame_time_s;
        newest_arrival_s_ = stamp->arrival_s;
        count(*stamp);
        if (is_live()) {
            clock_.arrived(stamp->frame_time_s, stamp->arrival_s);
            clock_runs_ = true;
            continue;
        }
        waiting_.push_back(*stamp);
        if (clock_runs_)
            clock_.arrived(stamp->frame_time_s, stamp->frame_time_s + due_s_);
    }
}

void Playback::count(const FrameStamp& stamp) {
    came_.push_back(stamp.number);
    counts_.late += is_live() && shown_number_ >= 0 && stamp.frame_time_s < time_s_ - same_time_s;
    if (last_arrival_ && stamp.number < last_arrival_->number) {  // out of order: it was counted as lost
        counts_.lost = std::max<std::int64_t>(0, counts_.lost - 1);
        return;
    }
    if (last_arrival_) {
        if (loader_.is_posed() || is_live())  // other videos' frames are numbered by their times
            counts_.lost += std::max<std::int64_t>(0, stamp.ordinal - last_arrival_->ordinal - 1);
        const double between_s = stamp.arrival_s - last_arrival_->arrival_s;
        const double off_s = std::abs(between_s - (stamp.frame_time_s - last_arrival_->frame_time_s));
        jitter_s_ += (off_s - jitter_s_) / jitter_frames;
    }
    last_arrival_ = stamp;
}

Playback::Moment Playback::refresh(double now_s) {
    const double before_s = std::exchange(is_held_, false) ? now_s : now_s_.value_or(now_s);
    const double elapsed_s = std::clamp(now_s - before_s, 0.0, longest_step_s);
    now_s_ = now_s;
    // Asked before arrivals are: of what has ended, all have come.
    LoaderState loaded = loader_.state();
    attempts_ = loaded.attempts;
    has_ended_ = loaded.ended;
    if (loaded.reel != reel_) {
        const bool steps = stepping_;
        forget_reel();
        if (is_live())  // a paused picture stays, whatever the server begins
            stepping_ = steps;
        reel_ = std::move(loaded.reel);
    }
    take_arrivals();
    if (!is_moving()) {
        if (is_live())
            came_.clear();  // nobody waits for them
        return {};
    }
    if (loaded.failed && waiting_.empty()) {
        paused_ = true;
        stepping_ = false;
        loader_.rethrow();
    }
    return is_live() ? refresh_live(loaded.ended, elapsed_s) : refresh_recorded(loaded.ended, elapsed_s);
}

double Playback::extrapolation_s(double max_ahead_s, double until_seen_s) const {
    const double ahead_s = is_live() && path_delay_s_ ? std::clamp(behind_s_ + until_seen_s, 0.0, max_ahead_s) : 0;
    return shown_number_ < 0 ? 0 : std::max(0.0, time_s_ - shown_s_) + ahead_s;
}

Playback::Moment Playback::refresh_live(bool ended, double elapsed_s) {
    if (ended)
        clock_.end();
    const std::optional<MediaTime> time = clock_.at(*now_s_);
    if (!time)
        return {};
    state_ = time->state;
    Moment moment = show(time->frame_time_s);
    const double path_s = clock_.path_delay_s(), known_s = path_delay_s_.value_or(path_s);
    path_delay_s_ = known_s + (path_s - known_s) * -std::expm1(-elapsed_s / settle_s);
    behind_s_ = *now_s_ - *path_delay_s_ - time_s_;
    stepping_ = false;
    if (state_ == ClockState::ended && !over_)
        moment.is_over = over_ = true;
    return moment;
}

/// The clock starts with the next frame that waits.
void Playback::begin_at_next() {
    clock_ = MediaClock(recorded_options);
    due_s_ = base_s_ - recorded_options.min_delay_s - waiting_.front().frame_time_s;
    for (const FrameStamp& stamp : waiting_)
        clock_.arrived(stamp.frame_time_s, stamp.frame_time_s + due_s_);
    clock_runs_ = true;
    stepping_ = false;
}

Playback::Moment Playback::refresh_recorded(bool ended, double elapsed_s) {
    if (stepping_ && waiting_.empty())
        return ended ? finish() : Moment{};
    if (over_ && !clock_runs_)  // a jump beyond the last frame
        return {};
    if (stepping_) {
        begin_at_next();
    } else {
        const double room_s = ended ? std::numeric_limits<double>::infinity() : newest_s_ + interval_s() - time_s_;
        base_s_ += std::min(elapsed_s, std::max(0.0, room_s));
    }
    const MediaTime time = *clock_.at(base_s_);
    state_ = time.state;
    Moment moment = show(time.frame_time_s);
    // Not by the clock's own time, which stops soon after the newest frame's: it may know of one frame alone.
    if (moment.frame)
        shown_since_s_ = base_s_;
    if (!moment.frame && ended && waiting_.empty() && base_s_ - shown_since_s_ >= interval_s() - same_time_s)
        return finish();
    return moment;
}

Playback::Moment Playback::finish() {
    stepping_ = false;
    return {nullptr, !std::exchange(over_, true)};
}

Playback::Moment Playback::show(double frame_time_s) {
    time_s_ = frame_time_s;
    const auto frames = reel_->show(frame_time_s);
    if (frames.empty() || reel_->stamp(frames[0]).number == shown_number_)
        return {};
    const bool is_first = std::exchange(shown_number_, reel_->stamp(frames[0]).number) < 0;
    const auto done = std::erase_if(came_, [&](std::int64_t number) { return number <= shown_number_; });
    if (!is_first && done > 1)
        counts_.skipped += std::int64_t(done) - 1;
    last_shown_ = reel_->stamp(frames[0]);
    shown_s_ = last_shown_->frame_time_s;
    const auto passed = std::erase_if(waiting_, [&](const FrameStamp& stamp) { return stamp.number <= shown_number_; });
    loader_.passed(*reel_, passed);
    // Taken out of the ring: nobody else keeps a frame that is no longer shown.
    LoadedFrame loaded = std::exchange(reel_->payload(frames[0]), {});
    assert(loaded.frame != nullptr);
    fraction_done_ = loaded.fraction_done;
    return {std::move(loaded.frame), false};
}

/// Poses travel unchanged, but for what rounding does.
bool is_same(const Pose& a, const Pose& b) {
    constexpr double same_place_m = 1e-9, same_turn = 1e-9;
    const glm::dquat& q = b.orientation;
    return glm::distance(a.position_m, b.position_m) <= same_place_m &&
           std::min(glm::length(a.orientation - q), glm::length(a.orientation + q)) <= same_turn;
}

void FollowedHead::show(const Pose& frame_head) {
    const auto is_frames = [&](const Pose& head) { return is_same(head, frame_head); };
    is_followed_ = std::ranges::any_of(sent_, is_frames);
    if (!is_followed_ && std::ranges::none_of(looked_, is_frames))
        around_ = frame_head;
}

void FollowedHead::looked(const Pose& head) {
    if (is_same(head, around_))
        return;  // a frame of the scene's own path may be there
    keep(looked_, head);
}

void FollowedHead::sent(const Pose& head) {
    keep(sent_, head);
}

void FollowedHead::keep(std::deque<Pose>& heads, const Pose& head) {
    heads.push_back(head);
    if (heads.size() > max_sent)
        heads.pop_front();
}

}  // namespace equistream
