#pragma once
/// What of a window's inputs is for the face, and what for the picture. In the displaying thread.
#include "face/face.h"
#include "input_box.h"

#include <optional>
#include <string>
#include <vector>

namespace equistream {

/// What steers, as it is from a moment on; and what was dragged until then.
struct InputSample {
    Clock::time_point at;
    HeldActions held;
    Sticks sticks;
    double drag_x = 0, drag_y = 0;  ///< of the mouse with its left button down, in pixels of the window
};

/// For the picture, in its order.
struct ViewInputs {
    std::vector<InputSample> samples;
    std::vector<Action> pressed;  ///< what keys that were pressed are bound to
    double scroll = 0;            ///< steps; up is positive
    double click_x = -1;          ///< 0 to 1 along the window where a right button went down; else negative
    std::optional<std::string> dropped;
    bool any = false;  ///< something happened, if only that the window has to be drawn again
    bool is_closed = false;
    gl::Size window;  ///< its framebuffer in pixels; 0: minimised

    /// What happened; what is so stays.
    void forget() {
        samples.clear();
        pressed.clear();
        scroll = 0;
        click_x = -1;
        any = false;
    }
};

class InputRouter {
public:
    /// Appends to `inputs`; what is to be said again (window, is_closed) is as it is now.
    void route(const WindowInputs& window, Face& face, ViewInputs& inputs);

private:
    void route_key(const KeyEvent& key, Face& face, ViewInputs& inputs);
    void route_button(const ButtonEvent& button, const Face& face, ViewInputs& inputs);

    PointerEvent pointer_;
    bool is_dragging_ = false;  ///< the picture, with the left button
    double drag_x_ = 0, drag_y_ = 0;
};

}  // namespace equistream
