#include "timeline.h"

#include <algorithm>
#include <cmath>

namespace equistream {

std::int64_t Timeline::frames() const {
    return std::max<std::int64_t>(1, std::llround(seconds * frames_per_second));
}

double time_at(const Timeline& timeline, const TimelineBar& bar, float x) {
    const double fraction = std::clamp(double(x - bar.left) / double(bar.width), 0.0, 1.0);
    const auto frames = double(timeline.frames());
    return timeline.first_s + std::min(std::floor(fraction * frames), frames - 1) / timeline.frames_per_second;
}

float place_of(const Timeline& timeline, const TimelineBar& bar, double time_s) {
    const double fraction = timeline.is_known() ? (time_s - timeline.first_s) / timeline.seconds : 0;
    return bar.left + bar.width * float(std::clamp(fraction, 0.0, 1.0));
}

}  // namespace equistream
