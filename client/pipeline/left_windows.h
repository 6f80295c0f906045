#pragma once
/// Which windows stay once the gaze has left them, so that a turn back finds what it left.
#include "decisions.h"

#include <client/warp/engine.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace equistream {

/// Newest first. A `Window` says what its camera() and its time_s() are.
template <typename Window>
class LeftWindows {
public:
    /// Windows half a window apart stay. One gives its place to another beside it that is as far right, or so much
    /// newer that the gaze has come to rest there: a gaze that wanders leaves a trail. Returns one that does not stay,
    /// if any, for its memory.
    std::optional<Window> leave(Window left) {
        std::erase_if(windows_, [&](const Window& other) { return !counts_as_left(other.time_s(), left.time_s()); });
        const auto beside = std::ranges::find_if(
            windows_, [&](const Window& other) { return mostly_overlap(other.camera(), left.camera()); });
        if (beside != windows_.end()) {
            if (same_camera(beside->camera(), left.camera()) || !counts_as_earlier(beside->time_s(), left.time_s()))
                std::swap(*beside, left);
            return left;
        }
        windows_.push_front(std::move(left));
        if (windows_.size() <= kept)
            return std::nullopt;
        std::optional<Window> oldest = std::move(windows_.back());
        windows_.pop_back();
        return oldest;
    }

    /// `take(window)` of each that may show what a frame's window does not.
    template <typename Take>
    void each_beside(const Camera& window, double time_s, const Take& take) {
        for (Window& other : windows_)
            if (counts_as_left(other.time_s(), time_s) && !mostly_overlap(other.camera(), window))
                take(other);
    }

    template <typename Take>
    void each(const Take& take) {
        std::ranges::for_each(windows_, take);
    }
    void clear() { windows_.clear(); }

private:
    /// A third of a turn to each side.
    static constexpr std::size_t kept = 4;

    std::deque<Window> windows_;
};

}  // namespace equistream
