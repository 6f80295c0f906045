#include "input_router.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace equistream {

namespace {

bool goes_on_by_repeats(Action action) {
    constexpr std::array repeated = {Action::frame_back, Action::frame_on,    Action::second_back, Action::second_on,
                                     Action::split_left, Action::split_right, Action::darker,      Action::brighter};
    return std::ranges::find(repeated, action) != repeated.end();
}

}  // namespace

void InputRouter::route_key(const KeyEvent& key, Face& face, ViewInputs& inputs) {
    if (!key.is_down || face.takes(key)) {
        face.feed(key);
        return;
    }
    if (const KeyBinding* binding = binding_of(key.key, key.modifiers);
        binding != nullptr && !is_held(binding->action) && (!key.is_repeated || goes_on_by_repeats(binding->action)))
        inputs.pressed.push_back(binding->action);
}

void InputRouter::route_button(const ButtonEvent& button, const Face& face, ViewInputs& inputs) {
    if (button.button == GLFW_MOUSE_BUTTON_LEFT)
        is_dragging_ = button.is_down && !face.has_pointer();
    if (button.button == GLFW_MOUSE_BUTTON_RIGHT && button.is_down && !face.has_pointer() && inputs.window.width > 0)
        inputs.click_x = double(pointer_.x) / inputs.window.width;
}

void InputRouter::route(const WindowInputs& window, Face& face, ViewInputs& inputs) {
    inputs.any = inputs.any || window.any;
    inputs.is_closed = window.is_closed;
    inputs.window = window.window;
    for (std::size_t i = 0; i < window.events.size(); ++i) {
        const InputEvent& event = window.events[i];
        // Mice tell more places a refresh than anybody sees.
        const bool is_passed = std::holds_alternative<PointerEvent>(event) && i + 1 < window.events.size() &&
                               std::holds_alternative<PointerEvent>(window.events[i + 1]);
        if (const auto* key = std::get_if<KeyEvent>(&event)) {
            route_key(*key, face, inputs);
        } else if (const auto* steering = std::get_if<SteeringEvent>(&event)) {
            inputs.samples.push_back({steering->at, face.has_keyboard() ? HeldActions() : steering->held,
                                      steering->sticks, std::exchange(drag_x_, 0), std::exchange(drag_y_, 0)});
        } else if (const auto* drop = std::get_if<DropEvent>(&event)) {
            inputs.dropped = drop->path;
        } else if (const auto* wheel = std::get_if<WheelEvent>(&event); wheel != nullptr && !face.has_pointer()) {
            inputs.scroll += wheel->steps;
        } else if (!is_passed && (!std::holds_alternative<TextEvent>(event) || face.has_keyboard())) {
            face.feed(event);
        }
        if (const auto* pointer = std::get_if<PointerEvent>(&event)) {
            if (is_dragging_) {
                drag_x_ += double(pointer->x - pointer_.x);
                drag_y_ += double(pointer->y - pointer_.y);
            }
            pointer_ = *pointer;
        } else if (const auto* button = std::get_if<ButtonEvent>(&event)) {
            route_button(*button, face, inputs);
        }
    }
}

}  // namespace equistream
