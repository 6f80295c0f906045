#pragma once
/// Dear ImGui on the window's context: its letters, its inputs and its drawing. What it is to say is built by callers.
/// One at a time, in the thread that the context is current in.
#include "font.h"

#include <client/view/input_box.h>

#include <client/gpu/objects.h>
#include <equistream/elapsed.h>

#include <functional>

namespace equistream {

class Gui {
public:
    /// Calls of Dear ImGui, from one frame's begin to its end.
    using Build = std::function<void()>;

    Gui();
    ~Gui();
    Gui(const Gui&) = delete;
    Gui& operator=(const Gui&) = delete;

    /// Before the first of the others. Letters are drawn anew where the scale changes.
    void resize(gl::Size window, double scale);
    /// What happened, and what is built after it.
    void feed(const InputEvent& event, const Build& build);
    /// Into the framebuffer that is bound.
    void draw(const Build& build);

    /// What the pointer does is for a panel: it is over one, or was when its button went down.
    bool has_pointer() const;
    /// What is typed is for a panel.
    bool has_keyboard() const;

private:
    void apply(const InputEvent& event);
    void pass(const Build& build);

    FontFile font_;
    int height_px_ = 0;
    Clock::time_point last_pass_ = Clock::now();
};

}  // namespace equistream
