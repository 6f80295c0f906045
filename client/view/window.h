#pragma once
/// A window with an OpenGL 4.5 core context, by GLFW. One at a time, and in the main thread alone but for its context
/// and what says so.
#include "input_box.h"

#include <client/gpu/context.h>
#include <client/gpu/objects.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

struct GLFWwindow;

namespace equistream {

/// What happened since the last poll, in its order; no steering.
struct Inputs {
    std::vector<InputEvent> events;
    bool is_dragged = false;  ///< the pointer moved with its left button down
    bool is_damaged = false;  ///< what it showed has to be shown again
};

class Window : public gl::Context {
public:
    /// Current when it returns. Throws InputError in one line where there is no display, or no OpenGL 4.5 with what is
    /// drawn with on it.
    /// `place`: where it was; nothing: wherever, of this size.
    static std::unique_ptr<Window> open(const std::string& title, gl::Size size,
                                        const std::optional<DesktopPlace>& place = {});
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
    /// Of the display that it is on: 1 at 96 dots per inch.
    double scale() const;
    /// Where it is, or was before it went full screen.
    DesktopPlace place() const;
    void set_title(const std::string& title);
    void toggle_fullscreen();

private:
    explicit Window(GLFWwindow* window);
    void keep_pace();

    struct Pointer;

    GLFWwindow* window_;
    std::unique_ptr<Pointer> pointer_;
    std::atomic<double> refresh_hz_ = 60;
    DesktopPlace place_;  ///< before it went full screen
};

}  // namespace equistream
