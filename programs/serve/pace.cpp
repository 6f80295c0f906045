#include "pace.h"

#include <algorithm>

namespace equistream::serve {

namespace {

/// Of the time there is: with twice the samples a sphere takes up to twice as long.
constexpr double too_slow = 1.05, quick = 0.4;
/// One slow sphere may be somebody else's doing.
constexpr int slow_spheres = 2;
constexpr int min_after_failure = 8, max_after_failures = 64;

}  // namespace

Pace::Change Pace::took(double sphere_s) {
    slow_ = sphere_s > too_slow * target_s_ ? slow_ + 1 : 0;
    quick_ = sphere_s < quick * target_s_ ? quick_ + 1 : 0;
    if (slow_ == slow_spheres && spp_ > 1) {
        spp_ /= 2;
        slow_ = 0;
        quick_enough_ = std::clamp(2 * quick_enough_, min_after_failure, max_after_failures);
        return Change::fewer;
    }
    if (slow_ >= 2 * slow_spheres && !has_said_so_) {
        has_said_so_ = true;
        return Change::cannot_keep_up;
    }
    if (quick_ >= quick_enough_ && spp_ < max_spp_) {
        spp_ = std::min(2 * spp_, max_spp_);
        quick_ = 0;
    }
    return Change::none;
}

}  // namespace equistream::serve
