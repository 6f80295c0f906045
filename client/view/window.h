#pragma once
/// A window with an OpenGL 4.5 core context, by GLFW. One at a time, and in the main thread alone.
#include <gl/context.h>
#include <gl/objects.h>

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
};

/// A gamepad's sticks and triggers, -1 to 1, dead zones cut out; all 0 where there is none.
struct Sticks {
    double turn_x = 0, turn_y = 0, move_x = 0, move_z = 0, move_y = 0;
};

class Window : public gl::Context {
public:
    /// Current when it returns. Throws InputError in one line where there is no display, or no OpenGL 4.5 with what is
    /// drawn with on it.
    static std::unique_ptr<Window> open(const std::string& title, gl::Size size);
    ~Window() override;

    void make_current() override;
    void release() override;

    /// Handles what the system has to say.
    Inputs poll();
    bool is_down(int key) const;
    Sticks sticks() const;
    bool should_close() const;
    /// Of the framebuffer, in pixels; 0 where it is minimised.
    gl::Size size() const;
    void toggle_fullscreen();
    /// Shows what was drawn, at the display's next refresh.
    void show();
    /// Sleeps until something happens, at most so long.
    void wait(double seconds);
    GLFWwindow* handle() const { return window_; }

private:
    explicit Window(GLFWwindow* window);

    struct Pointer;

    GLFWwindow* window_;
    std::unique_ptr<Pointer> pointer_;
    int left_ = 0, top_ = 0, width_ = 0, height_ = 0;  ///< before it went full screen
};

}  // namespace equistream
