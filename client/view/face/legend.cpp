#include "legend.h"
#include "parts.h"

#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <utility>

namespace equistream {

namespace {

/// In lines of text.
constexpr float bar_width = 15, bar_height = 0.8f, square = 0.8f;

/// Who colours pixels on the GPU, but for the main picture.
constexpr std::array gap_origins = {PixelOrigin::gap,      PixelOrigin::hidden, PixelOrigin::patches,
                                    PixelOrigin::earlier,  PixelOrigin::small,  PixelOrigin::base,
                                    PixelOrigin::push_pull};
constexpr std::array depth_marks_m = {1, 2, 5, 10, 20, 50};

ImU32 in_imgui(const gl::OverlayColour& colour) {
    return ImGui::GetColorU32({colour.red, colour.green, colour.blue, 1});
}

/// Where a bar is to be: its upper left corner, and how large.
std::pair<ImVec2, ImVec2> take_bar() {
    const float line = ImGui::GetFontSize();
    const ImVec2 corner = ImGui::GetCursorScreenPos(), size(bar_width * line, bar_height * line);
    ImGui::Dummy(size);
    return {corner, size};
}

void shade(ImVec2 from, ImVec2 to, ImU32 left, ImU32 right) {
    ImGui::GetWindowDrawList()->AddRectFilledMultiColor(from, to, left, right, right, left);
}

/// From near to far, with metres below.
void build_depth() {
    text("distance ahead, metres");
    const auto [corner, size] = take_bar();
    const float middle = corner.x + 0.5f * size.x, bottom = corner.y + size.y;
    shade(corner, {middle, bottom}, in_imgui(gl::depth_colours[2]), in_imgui(gl::depth_colours[1]));
    shade({middle, corner.y}, {corner.x + size.x, bottom}, in_imgui(gl::depth_colours[1]),
          in_imgui(gl::depth_colours[0]));
    const float line = ImGui::GetFontSize();
    ImDrawList& drawn = *ImGui::GetWindowDrawList();
    for (const int z_m : depth_marks_m) {
        const float x = corner.x + size.x * float(z_m) / (gl::half_depth_m + float(z_m));
        drawn.AddLine({x, bottom - 0.3f * line}, {x, bottom + 0.1f * line}, IM_COL32_WHITE);
        const std::string mark = std::to_string(z_m);
        drawn.AddText({x - 0.5f * ImGui::CalcTextSize(mark.c_str()).x, bottom + 0.1f * line}, IM_COL32_WHITE,
                      mark.c_str());
    }
    ImGui::Dummy({0, 1.2f * line});
    text("dark: no surface");
}

void build_reliability() {
    text("confidence: how likely a pixel is right");
    const auto [corner, size] = take_bar();
    shade(corner, {corner.x + size.x, corner.y + size.y}, in_imgui(gl::unreliable_colour),
          IM_COL32(200, 200, 200, 255));
    text("0 %");
    ImGui::SameLine(ImGui::GetCursorPosX() + bar_width * ImGui::GetFontSize() - ImGui::CalcTextSize("100 %").x);
    text("100 %");
}

void build_gaps() {
    text("gaps, by what filled them");
    const float side = square * ImGui::GetFontSize();
    for (const PixelOrigin origin : gap_origins) {
        const ImVec2 corner = ImGui::GetCursorScreenPos();
        ImGui::GetWindowDrawList()->AddRectFilled(corner, {corner.x + side, corner.y + side},
                                                  in_imgui(gl::origin_colours[std::size_t(origin)]));
        ImGui::Dummy({side, side});
        ImGui::SameLine();
        text(gl::origin_words[std::size_t(origin)]);
    }
}

void build_motion(const FaceContent& content) {
    text(content.knows_motion
             ? formatted("direction and speed; %.0f degrees a second at the rim", gl::full_motion_deg_per_s)
             : "no object motion in the stream");
}

bool has_legend(const FaceContent& content) {
    return content.shown.overlay != gl::Overlay::none && content.shown.layout != gl::DisplayLayout::sphere;
}

}  // namespace

void build_legend_items(const FaceContent& content) {
    if (!has_legend(content))
        return;
    switch (content.shown.overlay) {
    case gl::Overlay::none:
        break;
    case gl::Overlay::depth:
        build_depth();
        break;
    case gl::Overlay::gaps:
        build_gaps();
        break;
    case gl::Overlay::reliability:
        build_reliability();
        break;
    case gl::Overlay::motion:
        build_motion(content);
        break;
    }
}

void build_legend(const FaceContent& content, float right, float bottom) {
    if (!has_legend(content))
        return;
    // The colours of motion are a disc of the picture itself, which the words stand above.
    constexpr int above = gl::motion_legend.from_bottom + gl::motion_legend.radius;
    if (content.shown.overlay == gl::Overlay::motion)
        bottom = std::min(bottom, ImGui::GetIO().DisplaySize.y - float(above));
    ImGui::SetNextWindowPos({right - face_margin(), bottom - face_margin()}, ImGuiCond_Always, {1, 1});
    ImGui::SetNextWindowBgAlpha(face_alpha);
    ImGui::Begin("legend", nullptr, plain_window);
    build_legend_items(content);
    ImGui::End();
}

}  // namespace equistream
