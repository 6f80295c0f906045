#pragma once
/// Every key of the viewer, in one table: what handles keys, what `h` and the menus show and what `--keys` prints are
/// made from it.
#include <span>
#include <string>
#include <string_view>

namespace equistream {

enum class Action {
    // Held down, they go on.
    move_forward,
    move_back,
    move_left,
    move_right,
    move_up,
    move_down,
    turn_left,
    turn_right,
    turn_up,
    turn_down,
    // Once a press.
    centre,
    play_pause,
    frame_back,
    frame_on,
    second_back,
    second_on,
    to_start,
    loop,
    next_layout,
    next_anaglyph,
    next_overlay,
    next_method,
    fill,
    darker,
    brighter,
    split,
    split_left,
    split_right,
    picture,
    record_view,
    record_head,
    times,
    help,
    panel,
    open,
    fullscreen,
    quit,
};

struct KeyBinding {
    int key = 0, modifiers = 0;  ///< GLFW's
    std::string_view name;       ///< as people call it
    Action action = Action::quit;
    std::string_view task;  ///< under which help lists it
    std::string_view help;
};

/// In the order in which help lists them. Several keys may do one thing.
std::span<const KeyBinding> key_bindings();
/// Actions up to this one are for as long as a key is down.
inline constexpr Action last_held_action = Action::turn_down;
inline constexpr bool is_held(Action action) {
    return action <= last_held_action;
}
/// The first of an action's; every action has one.
const KeyBinding& key_of(Action action);
/// Null where nothing is bound to it.
const KeyBinding* binding_of(int key, int modifiers);

/// One line a key, under the tasks' headings.
std::string key_help();

}  // namespace equistream
