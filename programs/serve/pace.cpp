#include "pace.h"

#include <algorithm>
#include <utility>

namespace equistream::serve {

namespace {

/// Of the time there is: with twice the samples a sphere takes up to twice as long.
constexpr double too_slow = 1.05, quick = 0.4;
/// One slow sphere may be somebody else's doing.
constexpr int slow_spheres = 2;
constexpr int min_after_failure = 8, max_after_failures = 64;

}  // namespace

std::string samples_text(const Samples& samples) {
    const std::string noun = samples.looked_at == 1 ? " sample a pixel" : " samples a pixel";
    return std::to_string(samples.looked_at) + noun +
           (samples.base ? " in the window, " + std::to_string(*samples.base) + " around it" : "");
}

/// False: there are as many as may be.
bool Pace::rise() {
    if (samples_.looked_at < max_spp_)
        samples_.looked_at = std::min(2 * samples_.looked_at, max_spp_);
    else if (samples_.base && *samples_.base < max_spp_)
        samples_.base = std::min(2 * *samples_.base, max_spp_);
    else
        return false;
    return true;
}

/// False: there is one each.
bool Pace::fall() {
    if (samples_.base && *samples_.base > 1)
        *samples_.base /= 2;
    else if (samples_.looked_at > 1)
        samples_.looked_at /= 2;
    else
        return false;
    return true;
}

Pace::Change Pace::took(double sphere_s) {
    slow_ = sphere_s > too_slow * target_s_ ? slow_ + 1 : 0;
    quick_ = sphere_s < quick * target_s_ ? quick_ + 1 : 0;
    if (slow_ == slow_spheres && fall()) {
        slow_ = 0;
        if (std::exchange(has_risen_, false))
            quick_enough_ = std::clamp(2 * quick_enough_, min_after_failure, max_after_failures);
        return Change::fewer;
    }
    if (slow_ >= 2 * slow_spheres && !has_said_so_) {
        has_said_so_ = true;
        return Change::cannot_keep_up;
    }
    if (quick_ >= quick_enough_ && rise()) {
        quick_ = 0;
        has_risen_ = true;
    }
    return Change::none;
}

}  // namespace equistream::serve
