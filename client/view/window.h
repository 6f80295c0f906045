#pragma once
/// A window with an OpenGL 4.5 core context, by GLFW. One at a time, and in the main thread alone but for its context
/// and what says so.
#include "input_box.h"

#include <client/gpu/context.h>
#include <client/gpu/objects.h>

#include <memory>
#include <string>
#include <vector>

struct GLFWwindow;

namespace equistream {

/// What happened since the last poll, in its order. Keys, modifiers and buttons are GLFW's.
struct KeyPress {
    int key = 0, modifiers = 0;
    bool repeated = false;
};
struct Inputs {
    std::vector<KeyPress> pressed;
    double drag_x = 0, drag_y = 0;  ///< of the mouse with its left button down, in window pixels
    double scroll = 0;              ///< steps; up is positive
    double click_x = -1;            ///< 0 to 1 along the window where a right button went down; else negative
    bool is_damaged = false;        ///< what it showed has to be shown again
};

class Window : public gl::Context {
public:
    /// Current when it returns. Throws InputError in one line where there is no display, or no OpenGL 4.5 with what is
    /// drawn with on it.
    static std::unique_ptr<Window> open(const std::string& title, gl::Size size);
    ~Window() override;

    // Any thread, one at a time.
    void make_current() override;
    void release() override;
    /// Shows what was drawn, at the display's next refresh. Where the context is current.
    void show();
    /// wait() returns.
    void wake();
    /// From now on show() comes back at once. Where the context is current.
    void do_not_wait_for_refreshes();
    double refresh_hz() const { return refresh_hz_; }

    /// Handles what the system has to say, which is waited for, at most so long.
    void wait(double seconds);
    /// What it said since it was asked for last.
    Inputs take_inputs();
    bool is_down(int key) const;
    Sticks sticks() const;
    bool should_close() const;
    /// Of the framebuffer, in pixels; 0 where it is minimised.
    gl::Size size() const;
    void toggle_fullscreen();

private:
    explicit Window(GLFWwindow* window);

    struct Pointer;

    GLFWwindow* window_;
    std::unique_ptr<Pointer> pointer_;
    double refresh_hz_ = 60;
    int left_ = 0, top_ = 0, width_ = 0, height_ = 0;  ///< before it went full screen
};

}  // namespace equistream
