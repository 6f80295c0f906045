#include "window.h"

#include <client/gpu/context.h>
#include <equistream/error.h>

// epoxy's entry points come before GLFW's own.
#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>

namespace equistream {

namespace {

constexpr double dead_zone = 0.12;

/// GLFW's own words on what went wrong last.
std::string last_error() {
    const char* text = nullptr;
    return glfwGetError(&text) == GLFW_NO_ERROR || text == nullptr ? "no reason given" : text;
}

/// Events are kept in their order, so that a drag counts that began and ended within one refresh.
struct Pointed {
    Inputs inputs;
    bool is_left_down = false, has_moved = false;
};

Pointed& pointed_of(GLFWwindow* window) {
    return *static_cast<Pointed*>(glfwGetWindowUserPointer(window));
}

void add(GLFWwindow* window, InputEvent event) {
    pointed_of(window).inputs.events.push_back(std::move(event));
}

/// From the window's own units to pixels of its framebuffer.
PointerEvent pointer_at(GLFWwindow* window, double x, double y) {
    int width = 0, height = 0;
    gl::Size size;
    glfwGetWindowSize(window, &width, &height);
    glfwGetFramebufferSize(window, &size.width, &size.height);
    return {float(x * size.width / std::max(1, width)), float(y * size.height / std::max(1, height))};
}

void on_cursor(GLFWwindow* window, double x, double y) {
    Pointed& pointed = pointed_of(window);
    pointed.inputs.is_dragged = pointed.inputs.is_dragged || pointed.is_left_down;
    add(window, pointer_at(window, x, y));
}

void on_key(GLFWwindow* window, int key, int, int action, int modifiers) {
    if (key == GLFW_KEY_UNKNOWN)
        return;
    modifiers &= GLFW_MOD_SHIFT | GLFW_MOD_CONTROL | GLFW_MOD_ALT;
    add(window, KeyEvent{key, modifiers, action != GLFW_RELEASE, action == GLFW_REPEAT});
    if (key == GLFW_KEY_V && modifiers == GLFW_MOD_CONTROL && action != GLFW_RELEASE)
        if (const char* text = glfwGetClipboardString(window); text != nullptr)
            add(window, TextEvent{text});
}

void on_text(GLFWwindow* window, unsigned code) {
    // A code point in UTF-8.
    std::string text;
    const auto append = [&text](unsigned byte) { text += char(static_cast<unsigned char>(byte)); };
    if (code < 0x80) {
        append(code);
    } else if (code < 0x800) {
        append(0xc0 | code >> 6);
    } else if (code < 0x10000) {
        append(0xe0 | code >> 12);
        append(0x80 | (code >> 6 & 0x3f));
    } else {
        append(0xf0 | code >> 18);
        append(0x80 | (code >> 12 & 0x3f));
        append(0x80 | (code >> 6 & 0x3f));
    }
    if (code >= 0x80)
        append(0x80 | (code & 0x3f));
    add(window, TextEvent{text});
}

void on_scroll(GLFWwindow* window, double, double y) {
    add(window, WheelEvent{y});
}

void on_button(GLFWwindow* window, int button, int action, int) {
    if (button == GLFW_MOUSE_BUTTON_LEFT)
        pointed_of(window).is_left_down = action == GLFW_PRESS;
    double x = 0, y = 0;
    glfwGetCursorPos(window, &x, &y);
    add(window, pointer_at(window, x, y));
    add(window, ButtonEvent{button, action == GLFW_PRESS});
}

void on_drop(GLFWwindow* window, int count, const char** paths) {
    if (count > 0)
        add(window, DropEvent{paths[0]});
}

void on_damage(GLFWwindow* window) {
    pointed_of(window).inputs.is_damaged = true;
}

void on_move(GLFWwindow* window, int, int) {
    pointed_of(window).has_moved = true;
}

double beyond_dead_zone(float x) {
    const double size = std::abs(double(x));
    return size <= dead_zone ? 0 : std::copysign((size - dead_zone) / (1 - dead_zone), double(x));
}

/// How much of the place a display shows; of both sides none is below 0.
gl::Size shown_part(GLFWmonitor* monitor, const DesktopPlace& place) {
    int left = 0, top = 0, width = 0, height = 0;
    glfwGetMonitorWorkarea(monitor, &left, &top, &width, &height);
    return {std::max(0, std::min(left + width, place.left + place.width) - std::max(left, place.left)),
            std::max(0, std::min(top + height, place.top + place.height) - std::max(top, place.top))};
}

std::span<GLFWmonitor*> monitors() {
    int count = 0;
    GLFWmonitor** all = glfwGetMonitors(&count);
    return {all, std::size_t(count)};
}

/// Whether enough of it would be on a display to be seen and taken hold of.
bool can_be_seen(const DesktopPlace& place) {
    constexpr int min_px = 64;
    return std::ranges::any_of(monitors(), [&](GLFWmonitor* monitor) {
        const gl::Size part = shown_part(monitor, place);
        return part.width >= std::min(min_px, place.width) && part.height >= std::min(min_px, place.height);
    });
}

/// The one that shows most of the place, the first one where none does; null where there is no display.
GLFWmonitor* monitor_of(const DesktopPlace& place) {
    const auto area = [&](GLFWmonitor* monitor) {
        const gl::Size part = shown_part(monitor, place);
        return std::int64_t(part.width) * part.height;
    };
    const std::span<GLFWmonitor*> all = monitors();
    return all.empty() ? nullptr : *std::ranges::max_element(all, {}, area);
}

}  // namespace

struct Window::Pointer : Pointed {};

std::unique_ptr<Window> Window::open(const std::string& title, gl::Size size,
                                     const std::optional<DesktopPlace>& place) {
    if (glfwInit() != GLFW_TRUE)
        throw InputError(
            expected_found("window", "a display to open a window on (DISPLAY or WAYLAND_DISPLAY)", last_error()));
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    GLFWwindow* window = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
    if (window == nullptr) {
        const std::string reason = last_error();
        glfwTerminate();
        throw InputError(expected_found("window", "OpenGL 4.5 on this display", reason));
    }
    if (place && can_be_seen(*place))
        glfwSetWindowPos(window, place->left, place->top);
    std::unique_ptr<Window> opened(new Window(window));
    if (const std::string missing = gl::missing_requirement(); !missing.empty())
        throw InputError(expected_found("window", "OpenGL 4.5 with " + missing, gl::Context::driver().renderer));
    return opened;
}

Window::Window(GLFWwindow* window) : window_(window), pointer_(std::make_unique<Pointer>()) {
    glfwSetWindowUserPointer(window_, static_cast<Pointed*>(pointer_.get()));
    glfwSetKeyCallback(window_, on_key);
    glfwSetCharCallback(window_, on_text);
    glfwSetDropCallback(window_, on_drop);
    glfwSetCursorPosCallback(window_, on_cursor);
    glfwSetScrollCallback(window_, on_scroll);
    glfwSetMouseButtonCallback(window_, on_button);
    glfwSetWindowRefreshCallback(window_, on_damage);
    glfwSetWindowPosCallback(window_, on_move);
    make_current();
    glfwSwapInterval(1);
    keep_pace();
}

Window::~Window() {
    glfwDestroyWindow(window_);
    glfwTerminate();
}

void Window::make_current() {
    glfwMakeContextCurrent(window_);
    if (glfwGetCurrentContext() != window_)
        throw WorkError("the window's OpenGL context cannot be made current: " + last_error());
}

void Window::release() {
    glfwMakeContextCurrent(nullptr);
}

/// With the display that it is on.
void Window::keep_pace() {
    GLFWmonitor* const full = glfwGetWindowMonitor(window_);
    GLFWmonitor* const monitor = full != nullptr ? full : monitor_of(place());
    const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
    if (mode != nullptr && mode->refreshRate > 0)
        refresh_hz_ = mode->refreshRate;
}

Inputs Window::take_inputs() {
    if (std::exchange(pointer_->has_moved, false))
        keep_pace();
    return std::exchange(pointer_->inputs, {});
}

bool Window::is_down(int key) const {
    return glfwGetKey(window_, key) == GLFW_PRESS;
}

Sticks Window::sticks() const {
    GLFWgamepadstate state;
    for (int id = GLFW_JOYSTICK_1; id <= GLFW_JOYSTICK_LAST; ++id) {
        if (glfwJoystickIsGamepad(id) != GLFW_TRUE || glfwGetGamepadState(id, &state) != GLFW_TRUE)
            continue;
        const auto axis = [&state](int which) { return beyond_dead_zone(state.axes[which]); };
        // Triggers rest at -1.
        const auto trigger = [&state](int which) { return beyond_dead_zone(0.5f * (state.axes[which] + 1)); };
        return {axis(GLFW_GAMEPAD_AXIS_RIGHT_X), axis(GLFW_GAMEPAD_AXIS_RIGHT_Y), axis(GLFW_GAMEPAD_AXIS_LEFT_X),
                axis(GLFW_GAMEPAD_AXIS_LEFT_Y),
                trigger(GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER) - trigger(GLFW_GAMEPAD_AXIS_LEFT_TRIGGER)};
    }
    return {};
}

bool Window::should_close() const {
    return glfwWindowShouldClose(window_) == GLFW_TRUE;
}

gl::Size Window::size() const {
    gl::Size size;
    glfwGetFramebufferSize(window_, &size.width, &size.height);
    return glfwGetWindowAttrib(window_, GLFW_ICONIFIED) == GLFW_TRUE ? gl::Size{} : size;
}

double Window::scale() const {
    float across = 1, down = 1;
    glfwGetWindowContentScale(window_, &across, &down);
    return double(std::max(across, down));
}

DesktopPlace Window::place() const {
    if (glfwGetWindowMonitor(window_) != nullptr)
        return place_;
    DesktopPlace place;
    glfwGetWindowPos(window_, &place.left, &place.top);
    glfwGetWindowSize(window_, &place.width, &place.height);
    return place;
}

void Window::set_title(const std::string& title) {
    glfwSetWindowTitle(window_, title.c_str());
}

void Window::toggle_fullscreen() {
    if (glfwGetWindowMonitor(window_) != nullptr) {
        glfwSetWindowMonitor(window_, nullptr, place_.left, place_.top, place_.width, place_.height, GLFW_DONT_CARE);
        return;
    }
    place_ = place();
    GLFWmonitor* monitor = monitor_of(place_);
    const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
    if (mode == nullptr)
        return;
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void Window::do_not_wait_for_refreshes() {
    glfwSwapInterval(0);
}

void Window::show() {
    glfwSwapBuffers(window_);
}

void Window::wait(double seconds) {
    glfwWaitEventsTimeout(seconds);
}

void Window::wake() {
    glfwPostEmptyEvent();
}

}  // namespace equistream
