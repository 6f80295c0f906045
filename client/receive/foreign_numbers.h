#pragma once
/// Numbers and times of pictures that say nothing of themselves.
#include <equistream/frame.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

namespace equistream {

/// Containers round times, some to milliseconds.
inline constexpr double container_rounding_s = 0.002;

/// A picture is shown when its container says, for frame rates vary. Its number is that time in frames, or the next one
/// where that is taken. One video's, in the order in which it is shown. Where its clock begins again, numbers and times
/// go on. A server that sends a file over and over does that.
class ForeignNumbers {
public:
    /// Of the next picture. `shown_s` as DecodedPicture::time_s; nothing: as long after the one before as the rate
    /// says.
    std::pair<std::int64_t, double> next(std::optional<double> shown_s, double frames_per_second) {
        constexpr double latest = max_frame_index;
        if (shown_s && last_ && *shown_s + restarted_s_ < last_->second - longest_step_back_s)
            restarted_s_ = last_->second + 1 / frames_per_second - *shown_s;
        if (shown_s)
            *shown_s += restarted_s_;
        std::int64_t number = last_ ? std::min(last_->first + 1, max_frame_index) : 0;
        if (shown_s) {
            const std::int64_t by_time = std::llround(std::clamp(*shown_s * frames_per_second, -latest, latest));
            number = last_ ? std::max(number, by_time) : by_time;
        }
        const double counted_s = double(number) / frames_per_second;
        const bool is_counted = !shown_s || std::abs(*shown_s - counted_s) <= container_rounding_s;
        const double time_s = is_counted ? counted_s : *shown_s;
        last_ = {number, last_ ? std::max(time_s, last_->second) : time_s};
        return *last_;
    }

    /// Pictures before this time are to be dropped. The next one may be from anywhere.
    void jump(double time_s) {
        last_.reset();
        restarted_s_ = 0;
        sought_s_ = time_s;
    }
    bool is_before_jump(std::optional<double> shown_s, double frames_per_second) const {
        constexpr double same_frame = 0.4;
        const double same_time_s = std::min(container_rounding_s, same_frame / frames_per_second);
        return sought_s_ && shown_s && *shown_s < *sought_s_ - same_time_s;
    }

private:
    /// Containers' times may step back so far without beginning again.
    static constexpr double longest_step_back_s = 0.5;

    std::optional<std::pair<std::int64_t, double>> last_;
    double restarted_s_ = 0;  // so much is added to its times since it began again
    std::optional<double> sought_s_;
};

}  // namespace equistream
