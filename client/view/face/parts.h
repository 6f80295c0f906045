#pragma once
/// What the parts of the face have in common: how their windows look. In a frame of Dear ImGui.
#include <imgui.h>

#include <string_view>

namespace equistream {

/// Windows that say something and take no input.
inline constexpr ImGuiWindowFlags plain_window =
    ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings |
    ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav | ImGuiWindowFlags_AlwaysAutoResize;
/// Windows at a fixed place that take some.
inline constexpr ImGuiWindowFlags fixed_window = ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize |
                                                 ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                                                 ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                                                 ImGuiWindowFlags_NoBringToFrontOnFocus;
inline constexpr float face_alpha = 0.8f;
inline const ImVec4 warning_colour{1, 0.6f, 0.3f, 1}, heading_colour{1, 0.85f, 0.4f, 1};

/// Between a window's border and what is in its corners, pixels.
inline float face_margin() {
    return 0.66f * ImGui::GetFontSize();
}

inline void text(std::string_view words) {
    ImGui::TextUnformatted(words.data(), words.data() + words.size());
}

}  // namespace equistream
