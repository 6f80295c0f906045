#pragma once
/// What the main thread, to which systems tell what keys and mice do, hands to the thread that displays; and what that
/// thread asks of the main thread. One small lock, held for as long as it takes to copy.
#include "keys.h"

#include <client/gpu/objects.h>

#include <atomic>
#include <bitset>
#include <condition_variable>
#include <mutex>
#include <vector>

namespace equistream {

using HeldActions = std::bitset<std::size_t(last_held_action) + 1>;

/// A gamepad's sticks and triggers, -1 to 1, dead zones cut out; all 0 where there is none.
struct Sticks {
    double turn_x = 0, turn_y = 0, move_x = 0, move_z = 0, move_y = 0;

    bool operator==(const Sticks&) const = default;
};

/// What steers, as it is from a moment on; and what was dragged until then.
struct InputSample {
    double time_s = 0;  ///< on the clock of who displays
    HeldActions held;
    Sticks sticks;
    double drag_x = 0, drag_y = 0;  ///< of the mouse with its left button down, in window pixels
};

/// What happened since it was asked for last, in its order.
struct TakenInputs {
    std::vector<InputSample> samples;
    std::vector<Action> pressed;  ///< what keys that were pressed are bound to
    double scroll = 0;            ///< steps; up is positive
    double click_x = -1;          ///< 0 to 1 along the window where a right button went down; else negative
    bool any = false;             ///< something happened, if only that the window has to be drawn again
    bool is_closed = false;       ///< from now on
    gl::Size window;              ///< its framebuffer in pixels; 0: minimised
};

class InputBox {
public:
    // The main thread.
    /// Appends: `inputs` as take() gives them.
    void put(const TakenInputs& inputs);
    bool is_over() const { return over_; }
    /// Once for each time that it was asked for.
    bool take_fullscreen_toggle() { return toggle_.exchange(false); }

    // The displaying thread.
    /// Swaps what came for what is in `inputs`, whose memory is used again.
    void take(TakenInputs& inputs);
    /// Until something comes, at most so long.
    void wait(double seconds);
    void ask_for_fullscreen_toggle() { toggle_ = true; }
    /// Nothing more will be displayed.
    void end() { over_ = true; }

private:
    std::mutex mutex_;
    std::condition_variable came_;
    TakenInputs inputs_;
    std::atomic<bool> over_ = false, toggle_ = false;
};

}  // namespace equistream
