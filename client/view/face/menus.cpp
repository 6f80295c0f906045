/// The menu bar: its settings from their table, its actions from that of the keys.
#include "face.h"
#include "parts.h"

#ifndef EQUISTREAM_VERSION
#error "the build says which version this is"
#endif

namespace equistream {

void Face::build_action(Action action, const char* label, bool is_chosen) {
    const std::string key(key_of(action).name);
    if (ImGui::MenuItem(label, key.c_str(), is_chosen))
        wish(action);
}

void Face::build_setting_menu(const ShownSetting& setting) {
    const std::string value = setting.value(content_.shown), label(setting.label);
    if (setting.is_switch() && setting.parts.empty()) {
        const std::string key(setting.key ? key_of(*setting.key).name : "");
        if (ImGui::MenuItem(label.c_str(), key.c_str(), value == "on"))
            choose(setting, value == "on" ? "off" : "on");
        return;
    }
    if (!is_offered(setting, {}, content_) || !ImGui::BeginMenu(label.c_str()))
        return;
    if (setting.words.empty())
        build_setting(setting);
    for (const std::string_view word : setting.words)
        if (ImGui::MenuItem(std::string(word).c_str(), nullptr, word == value, is_offered(setting, word, content_)))
            choose(setting, std::string(word));
    if (!setting.parts.empty())
        build_passes(setting);
    ImGui::EndMenu();
}

void Face::build_settings_menu(SettingMenu menu) {
    for (const ShownSetting& setting : shown_settings())
        if (setting.menu == menu)
            build_setting_menu(setting);
}

void Face::build_file_menu() {
    build_action(Action::open, "Open...");
    if (ImGui::BeginMenu("Open recent", !content_.recent.empty())) {
        for (std::size_t i = 0; i < content_.recent.size(); ++i) {
            ImGui::PushID(int(i));
            if (ImGui::MenuItem(content_.recent[i].c_str()))
                wish(OpenWish{content_.recent[i]});
            ImGui::PopID();
        }
        ImGui::EndMenu();
    }
    ImGui::Separator();
    build_action(Action::picture, "Save picture");
    build_action(Action::record_view, "Record the view", content_.records_view);
    build_action(Action::record_head, "Record the head's path", content_.records_head);
    ImGui::Separator();
    build_action(Action::quit, "Quit");
}

void Face::build_menu_bar() {
    if (!ImGui::BeginMainMenuBar())
        return;
    if (ImGui::BeginMenu("File")) {
        build_file_menu();
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("View")) {
        build_settings_menu(SettingMenu::view);
        ImGui::Separator();
        build_action(Action::split, "Split the window");
        build_action(Action::centre, "Centre the head");
        build_action(Action::fullscreen, "Full screen");
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Picture")) {
        build_settings_menu(SettingMenu::picture);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Time")) {
        build_action(Action::play_pause, content_.is_paused ? "Play" : "Pause");
        build_action(Action::frame_back, "Previous frame");
        build_action(Action::frame_on, "Next frame");
        build_action(Action::to_start, "To the start");
        ImGui::Separator();
        build_settings_menu(SettingMenu::time);
        ImGui::EndMenu();
    }
    if (ImGui::BeginMenu("Help")) {
        build_action(Action::help, "Keys", help_page_ > 0);
        if (ImGui::MenuItem("About"))
            shows_about_ = true;
        ImGui::EndMenu();
    }
    ImGui::EndMainMenuBar();
}

void Face::build_about() {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * window.x, 0.5f * window.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::Begin("about", nullptr,
                 (fixed_window & ~ImGuiWindowFlags_NoBringToFrontOnFocus) | ImGuiWindowFlags_AlwaysAutoResize);
    text("equistream " EQUISTREAM_VERSION);
    text("Streams of path-traced spheres, seen from wherever the head is.");
    if (ImGui::Button("Close"))
        shows_about_ = false;
    ImGui::End();
}

}  // namespace equistream
