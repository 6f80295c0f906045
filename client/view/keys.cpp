#include "keys.h"

#include <equistream/text.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>

namespace equistream {

constexpr int shift = GLFW_MOD_SHIFT, control = GLFW_MOD_CONTROL;
constexpr std::string_view look = "Look and move", time = "Time", shown = "What is shown", keep = "Save and record",
                           program = "Program";

constexpr auto bindings = std::to_array<KeyBinding>({
    {GLFW_KEY_LEFT, 0, "left", Action::turn_left, look, "turn left (or drag the mouse, or a gamepad's right stick)"},
    {GLFW_KEY_RIGHT, 0, "right", Action::turn_right, look, "turn right"},
    {GLFW_KEY_UP, 0, "up", Action::turn_up, look, "look up"},
    {GLFW_KEY_DOWN, 0, "down", Action::turn_down, look, "look down"},
    {GLFW_KEY_W, 0, "w", Action::move_forward, look, "move the head forward (or a gamepad's left stick)"},
    {GLFW_KEY_S, 0, "s", Action::move_back, look, "move it back"},
    {GLFW_KEY_A, 0, "a", Action::move_left, look, "move it left"},
    {GLFW_KEY_D, 0, "d", Action::move_right, look, "move it right"},
    {GLFW_KEY_E, 0, "e", Action::move_up, look, "move it up (or a gamepad's triggers)"},
    {GLFW_KEY_Q, 0, "q", Action::move_down, look, "move it down"},
    {GLFW_KEY_C, 0, "c", Action::centre, look,
     "centre the head in its box, look ahead, reset the zoom of the mouse wheel"},
    {GLFW_KEY_SPACE, 0, "space", Action::play_pause, time, "play, pause"},
    {GLFW_KEY_COMMA, 0, ",", Action::frame_back, time, "previous frame"},
    {GLFW_KEY_PERIOD, 0, ".", Action::frame_on, time, "next frame"},
    {GLFW_KEY_LEFT, shift, "shift left", Action::second_back, time, "one second back"},
    {GLFW_KEY_RIGHT, shift, "shift right", Action::second_on, time, "one second forward"},
    {GLFW_KEY_HOME, 0, "home", Action::to_start, time, "to the start"},
    {GLFW_KEY_L, 0, "l", Action::loop, time, "loop: at the end, start again or stop"},
    {GLFW_KEY_V, 0, "v", Action::next_layout, shown,
     "left eye, right eye, side by side, anaglyph, headset, the sphere itself"},
    {GLFW_KEY_V, shift, "shift v", Action::next_anaglyph, shown, "the next kind of anaglyph"},
    {GLFW_KEY_O, 0, "o", Action::next_overlay, shown, "overlay: none, depth, gaps, reliability, motion"},
    {GLFW_KEY_M, 0, "m", Action::next_method, shown, "method: by depth, rotation alone"},
    {GLFW_KEY_F, 0, "f", Action::fill, shown, "fill gaps, or leave them black"},
    {GLFW_KEY_MINUS, 0, "-", Action::darker, shown, "HDR: a quarter of a stop darker"},
    {GLFW_KEY_EQUAL, 0, "=", Action::brighter, shown, "HDR: a quarter of a stop brighter"},
    {GLFW_KEY_X, 0, "x", Action::split, shown, "split: the other method, or --truth, on the right"},
    {GLFW_KEY_LEFT_BRACKET, 0, "[", Action::split_left, shown, "move the split left (or click with the right button)"},
    {GLFW_KEY_RIGHT_BRACKET, 0, "]", Action::split_right, shown, "move the split right"},
    {GLFW_KEY_P, 0, "p", Action::picture, keep, "save a picture of the window"},
    {GLFW_KEY_R, 0, "r", Action::record_view, keep, "record the window as numbered pictures: start, stop"},
    {GLFW_KEY_R, shift, "shift r", Action::record_head, keep, "record the head's path as CSV: start, stop"},
    {GLFW_KEY_T, 0, "t", Action::times, program, "frame times by stage"},
    {GLFW_KEY_H, 0, "h", Action::help, program, "these keys"},
    {GLFW_KEY_TAB, 0, "tab", Action::panel, program,
     "panel of settings and values (the menu bar and the timeline appear when the mouse moves)"},
    {GLFW_KEY_O, control, "ctrl o", Action::open, program, "open another stream or folder (or drop it on the window)"},
    {GLFW_KEY_F11, 0, "F11", Action::fullscreen, program, "full screen"},
    {GLFW_KEY_ESCAPE, 0, "escape", Action::quit, program, "quit"},
});

std::span<const KeyBinding> key_bindings() {
    return bindings;
}

const KeyBinding& key_of(Action action) {
    return *std::ranges::find(bindings, action, &KeyBinding::action);
}

const KeyBinding* binding_of(int key, int modifiers) {
    const auto found =
        std::ranges::find_if(bindings, [&](const KeyBinding& b) { return b.key == key && b.modifiers == modifiers; });
    return found == bindings.end() ? nullptr : &*found;
}

std::string key_help() {
    std::string text;
    std::string_view task;
    for (const KeyBinding& b : bindings) {
        if (b.task != task)
            text += std::string(task.empty() ? "" : "\n") + std::string(b.task) + "\n";
        task = b.task;
        text += formatted("  %-12.*s %.*s\n", int(b.name.size()), b.name.data(), int(b.help.size()), b.help.data());
    }
    return text;
}

}  // namespace equistream
