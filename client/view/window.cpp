#include "window.h"

#include <client/gpu/context.h>
#include <equistream/error.h>

// epoxy's entry points come before GLFW's own.
#include <epoxy/gl.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <cmath>
#include <utility>

namespace equistream {

namespace {

constexpr double dead_zone = 0.12;

/// GLFW's own words on what went wrong last.
std::string last_error() {
    const char* text = nullptr;
    return glfwGetError(&text) == GLFW_NO_ERROR || text == nullptr ? "no reason given" : text;
}

/// Events are handled in their order, so that a drag counts that began and ended within one refresh.
struct Pointed {
    Inputs inputs;
    double x = 0, y = 0;
    bool dragging = false;
};

Pointed* pointed_of(GLFWwindow* window) {
    return static_cast<Pointed*>(glfwGetWindowUserPointer(window));
}

Inputs* inputs_of(GLFWwindow* window) {
    return &pointed_of(window)->inputs;
}

void on_cursor(GLFWwindow* window, double x, double y) {
    Pointed& pointed = *pointed_of(window);
    if (pointed.dragging) {
        pointed.inputs.drag_x += x - pointed.x;
        pointed.inputs.drag_y += y - pointed.y;
    }
    pointed.x = x;
    pointed.y = y;
}

void on_key(GLFWwindow* window, int key, int, int action, int modifiers) {
    if (action != GLFW_RELEASE && key != GLFW_KEY_UNKNOWN)
        inputs_of(window)->pressed.push_back(
            {key, modifiers & (GLFW_MOD_SHIFT | GLFW_MOD_CONTROL | GLFW_MOD_ALT), action == GLFW_REPEAT});
}

void on_scroll(GLFWwindow* window, double, double y) {
    inputs_of(window)->scroll += y;
}

void on_button(GLFWwindow* window, int button, int action, int) {
    if (button == GLFW_MOUSE_BUTTON_LEFT)
        pointed_of(window)->dragging = action == GLFW_PRESS;
    if (button != GLFW_MOUSE_BUTTON_RIGHT || action != GLFW_PRESS)
        return;
    double x = 0, y = 0;
    int width = 0, height = 0;
    glfwGetCursorPos(window, &x, &y);
    glfwGetWindowSize(window, &width, &height);
    inputs_of(window)->click_x = width > 0 ? x / width : -1;
}

void on_damage(GLFWwindow* window) {
    inputs_of(window)->is_damaged = true;
}

double beyond_dead_zone(float x) {
    const double size = std::abs(double(x));
    return size <= dead_zone ? 0 : std::copysign((size - dead_zone) / (1 - dead_zone), double(x));
}

}  // namespace

struct Window::Pointer : Pointed {};

std::unique_ptr<Window> Window::open(const std::string& title, gl::Size size) {
    if (glfwInit() != GLFW_TRUE)
        throw InputError(
            expected_found("view", "a display to open a window on (DISPLAY or WAYLAND_DISPLAY)", last_error()));
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    GLFWwindow* window = glfwCreateWindow(size.width, size.height, title.c_str(), nullptr, nullptr);
    if (window == nullptr) {
        const std::string reason = last_error();
        glfwTerminate();
        throw InputError(expected_found("view", "OpenGL 4.5 on this display", reason));
    }
    std::unique_ptr<Window> opened(new Window(window));
    if (const std::string missing = gl::missing_requirement(); !missing.empty())
        throw InputError(expected_found("view", "OpenGL 4.5 with " + missing, gl::Context::driver().renderer));
    return opened;
}

Window::Window(GLFWwindow* window) : window_(window), pointer_(std::make_unique<Pointer>()) {
    glfwSetWindowUserPointer(window_, static_cast<Pointed*>(pointer_.get()));
    glfwSetKeyCallback(window_, on_key);
    glfwSetCursorPosCallback(window_, on_cursor);
    glfwSetScrollCallback(window_, on_scroll);
    glfwSetMouseButtonCallback(window_, on_button);
    glfwSetWindowRefreshCallback(window_, on_damage);
    make_current();
    glfwSwapInterval(1);
    glfwGetCursorPos(window_, &pointer_->x, &pointer_->y);
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    if (const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
        mode != nullptr && mode->refreshRate > 0)
        refresh_hz_ = mode->refreshRate;
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

Inputs Window::take_inputs() {
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

void Window::toggle_fullscreen() {
    if (glfwGetWindowMonitor(window_) != nullptr) {
        glfwSetWindowMonitor(window_, nullptr, left_, top_, width_, height_, GLFW_DONT_CARE);
        return;
    }
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* mode = monitor == nullptr ? nullptr : glfwGetVideoMode(monitor);
    if (mode == nullptr)
        return;
    glfwGetWindowPos(window_, &left_, &top_);
    glfwGetWindowSize(window_, &width_, &height_);
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
