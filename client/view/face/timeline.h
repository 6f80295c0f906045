#pragma once
/// Time on a bar: where a moment of a source lies on it, and which frame is at a place of it. Pure functions.
#include <cstdint>

namespace equistream {

struct Timeline {
    double first_s = 0;            ///< of the first frame
    double seconds = 0;            ///< to the end of the last; 0: not known
    double frames_per_second = 0;  ///< above 0 where `seconds` is

    bool operator==(const Timeline&) const = default;

    bool is_known() const { return seconds > 0; }
    /// At least one.
    std::int64_t frames() const;
};

/// In pixels; `width` is above 0.
struct TimelineBar {
    float left = 0, width = 1;
};

/// When the frame begins that is shown at this place; beyond the bar's ends: the first and the last.
double time_at(const Timeline& timeline, const TimelineBar& bar, float x);
/// Where a moment lies, within the bar.
float place_of(const Timeline& timeline, const TimelineBar& bar, double time_s);

}  // namespace equistream
