#include "under_way.h"

#include <algorithm>

namespace equistream {

namespace {

/// A packet that was lost twice is acknowledged three times as late as others. Beyond that so much longer.
constexpr double soonest_times = 3, longest_s = 0.2;
/// So few bytes may always be under way: of what follows a lost packet the other end tells which one it lacks.
constexpr std::int64_t few_bytes = 1 << 12;

}  // namespace

void UnderWay::see(double time_s, std::int64_t written, const Unacknowledged& unacknowledged) {
    if (written > written_)
        writes_.push_back({time_s, written});
    written_ = written;
    acknowledged_ = std::max(acknowledged_, written - std::min(written, std::int64_t(unacknowledged.bytes)));
    while (!writes_.empty() && writes_.front().bytes <= acknowledged_)
        writes_.pop_front();
    soonest_s_ = unacknowledged.soonest_s;
}

bool UnderWay::is_too_much(double time_s) const {
    return written_ - acknowledged_ > few_bytes && oldest_s(time_s) > soonest_times * soonest_s_ + longest_s;
}

}  // namespace equistream
