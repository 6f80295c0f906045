#include "gui.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

namespace equistream {

namespace {

constexpr float min_step_s = 1e-4f, max_step_s = 0.1f;

/// Keys that fields of text know.
constexpr std::array<std::pair<ImGuiKey_, int>, 21> known_keys = {{{ImGuiKey_Tab, GLFW_KEY_TAB},
                                                                   {ImGuiKey_LeftArrow, GLFW_KEY_LEFT},
                                                                   {ImGuiKey_RightArrow, GLFW_KEY_RIGHT},
                                                                   {ImGuiKey_UpArrow, GLFW_KEY_UP},
                                                                   {ImGuiKey_DownArrow, GLFW_KEY_DOWN},
                                                                   {ImGuiKey_PageUp, GLFW_KEY_PAGE_UP},
                                                                   {ImGuiKey_PageDown, GLFW_KEY_PAGE_DOWN},
                                                                   {ImGuiKey_Home, GLFW_KEY_HOME},
                                                                   {ImGuiKey_End, GLFW_KEY_END},
                                                                   {ImGuiKey_Insert, GLFW_KEY_INSERT},
                                                                   {ImGuiKey_Delete, GLFW_KEY_DELETE},
                                                                   {ImGuiKey_Backspace, GLFW_KEY_BACKSPACE},
                                                                   {ImGuiKey_Space, GLFW_KEY_SPACE},
                                                                   {ImGuiKey_Enter, GLFW_KEY_ENTER},
                                                                   {ImGuiKey_Escape, GLFW_KEY_ESCAPE},
                                                                   {ImGuiKey_KeyPadEnter, GLFW_KEY_KP_ENTER},
                                                                   {ImGuiKey_A, GLFW_KEY_A},
                                                                   {ImGuiKey_C, GLFW_KEY_C},
                                                                   {ImGuiKey_X, GLFW_KEY_X},
                                                                   {ImGuiKey_Y, GLFW_KEY_Y},
                                                                   {ImGuiKey_Z, GLFW_KEY_Z}}};

}  // namespace

Gui::Gui() : font_(find_font()) {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;
    for (const auto& [name, key] : known_keys)
        io.KeyMap[name] = key;
    ImGui_ImplOpenGL3_Init("#version 450 core");
}

Gui::~Gui() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext();
}

void Gui::resize(gl::Size window, double scale) {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = {float(window.width), float(window.height)};
    const int height_px = font_height_px(scale);
    const int before_px = std::exchange(height_px_, height_px);
    if (before_px == height_px)
        return;
    load_font(*io.Fonts, font_, height_px);
    if (before_px == 0) {
        ImGui_ImplOpenGL3_CreateDeviceObjects();
    } else {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    }
    ImGuiStyle style;
    ImGui::StyleColorsDark(&style);
    style.WindowRounding = style.FrameRounding = style.GrabRounding = 3;
    style.WindowBorderSize = 0;
    style.ScaleAllSizes(float(height_px / line_height_px));
    ImGui::GetStyle() = style;
}

void Gui::apply(const InputEvent& event) {
    ImGuiIO& io = ImGui::GetIO();
    std::visit(Overloaded{[&](const KeyEvent& key) {
                              if (key.key >= 0 && key.key < int(std::size(io.KeysDown)))
                                  io.KeysDown[key.key] = key.is_down;
                              io.KeyShift = (key.modifiers & GLFW_MOD_SHIFT) != 0;
                              io.KeyCtrl = (key.modifiers & GLFW_MOD_CONTROL) != 0;
                              io.KeyAlt = (key.modifiers & GLFW_MOD_ALT) != 0;
                          },
                          [&](const TextEvent& text) {
                              io.KeyCtrl = false;  // a pasted text comes while it is down, and would be dropped
                              io.AddInputCharactersUTF8(text.text.c_str());
                          },
                          [&](const PointerEvent& pointer) {
                              io.MousePos = {pointer.x, pointer.y};
                          },
                          [&](const ButtonEvent& button) {
                              if (button.button >= 0 && button.button < int(std::size(io.MouseDown)))
                                  io.MouseDown[button.button] = button.is_down;
                          },
                          [&](const WheelEvent& wheel) { io.MouseWheel += float(wheel.steps); },
                          [](const DropEvent&) {}, [](const SteeringEvent&) {}},
               event);
}

/// Begins a frame of Dear ImGui and builds it.
void Gui::pass(const Build& build) {
    ImGuiIO& io = ImGui::GetIO();
    io.DeltaTime = std::clamp(float(seconds_since(std::exchange(last_pass_, Clock::now()))), min_step_s, max_step_s);
    ImGui::NewFrame();
    build();
}

// Panels take the size of what was in them the time before, and nothing may be drawn for long after this.

void Gui::feed(const InputEvent& event, const Build& build) {
    apply(event);
    for (int i = 0; i < 2; ++i) {
        pass(build);
        ImGui::EndFrame();
    }
}

void Gui::draw(const Build& build) {
    ImGui_ImplOpenGL3_NewFrame();
    pass(build);
    ImGui::EndFrame();
    pass(build);
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool Gui::has_pointer() const {
    return ImGui::GetIO().WantCaptureMouse;
}

bool Gui::has_keyboard() const {
    return ImGui::GetIO().WantTextInput;
}

}  // namespace equistream
