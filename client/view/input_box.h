#pragma once
/// What the main thread, to which systems tell what keys and mice do, hands to the thread that displays; and what that
/// thread asks of the main thread. One small lock, held for as long as it takes to copy.
#include "kept_settings.h"
#include "keys.h"

#include <client/gpu/objects.h>
#include <equistream/elapsed.h>

#include <atomic>
#include <bitset>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace equistream {

using HeldActions = std::bitset<std::size_t(last_held_action) + 1>;

/// A gamepad's sticks and triggers, -1 to 1, dead zones cut out; all 0 where there is none.
struct Sticks {
    double turn_x = 0, turn_y = 0, move_x = 0, move_z = 0, move_y = 0;

    bool operator==(const Sticks&) const = default;
};

// What may happen. Places are in pixels of the framebuffer, from its upper left corner; keys, modifiers and buttons are
// GLFW's.

struct KeyEvent {
    int key = 0, modifiers = 0;
    bool is_down = false, is_repeated = false;
};
/// Typed, or pasted. UTF-8.
struct TextEvent {
    std::string text;
};
struct PointerEvent {
    float x = 0, y = 0;
};
struct ButtonEvent {
    int button = 0;
    bool is_down = false;
};
struct WheelEvent {
    double steps = 0;  ///< up is positive
};
/// A file or folder was dropped on the window.
struct DropEvent {
    std::string path;
};
/// What steers from this moment on.
struct SteeringEvent {
    Clock::time_point at;
    HeldActions held;
    Sticks sticks;
};
using InputEvent = std::variant<KeyEvent, TextEvent, PointerEvent, ButtonEvent, WheelEvent, DropEvent, SteeringEvent>;

/// For std::visit: a function for each of a variant's kinds.
template <typename... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};

/// What happened since it was asked for last, in its order.
struct WindowInputs {
    std::vector<InputEvent> events;
    bool any = false;        ///< something happened, if only that the window has to be drawn again
    bool is_closed = false;  ///< from now on
    gl::Size window;         ///< its framebuffer in pixels; 0: minimised
    double scale = 1;        ///< of letters, on the display that it is on: 1 at 96 dots per inch
};

class InputBox {
public:
    // The main thread.
    /// Appends: `inputs` as take() gives them.
    void put(const WindowInputs& inputs);
    bool is_over() const { return over_; }
    /// Each once for each time that it was asked for.
    bool take_fullscreen_toggle() { return toggle_.exchange(false); }
    std::optional<std::string> take_title();
    std::optional<KeptSettings> take_kept();

    // The displaying thread.
    /// Swaps what came for what is in `inputs`, whose memory is used again.
    void take(WindowInputs& inputs);
    /// Until something comes, at most so long.
    void wait(double seconds);
    void ask_for_fullscreen_toggle() { toggle_ = true; }
    void ask_for_title(std::string title);
    /// That these are written, but for the window's place.
    void ask_to_keep(KeptSettings kept);
    /// Nothing more will be displayed.
    void end() { over_ = true; }

    // Any thread.
    /// wait() returns, as if the window had to be drawn again.
    void wake();

private:
    std::mutex mutex_;
    std::condition_variable came_;
    WindowInputs inputs_;
    std::optional<std::string> title_;
    std::optional<KeptSettings> kept_;
    std::atomic<bool> over_ = false, toggle_ = false;
};

}  // namespace equistream
