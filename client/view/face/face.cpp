#include "face.h"
#include "legend.h"
#include "parts.h"

#include <equistream/text.h>

#include <imgui_internal.h>  // ClosePopupToLevel
#include <imgui_stdlib.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cmath>

namespace equistream {

namespace {

constexpr float keys_alpha = 0.93f;  // they may lie over other figures
/// In lines of text.
constexpr float bar_height = 0.55f, button_width = 1.4f, source_field_width = 34;

bool has_menu_open() {
    return ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopupId | ImGuiPopupFlags_AnyPopupLevel);
}

float menu_bar_height() {
    return ImGui::GetFrameHeight();
}

/// A bar, a line, and what is around them.
float timeline_height() {
    const ImGuiStyle& style = ImGui::GetStyle();
    return bar_height * ImGui::GetFontSize() + style.ItemSpacing.y + ImGui::GetFrameHeight() +
           2 * style.WindowPadding.y;
}

/// "1:02.50"
std::string clock_text(double time_s) {
    const double shown_s = std::round(100 * std::max(0.0, time_s)) / 100, minutes = std::floor(shown_s / 60);
    return formatted("%.0f:%05.2f", minutes, shown_s - 60 * minutes);
}

/// A triangle that points on, or two bars; drawn, for not every font has them.
bool build_play_button(bool is_paused) {
    const float line = ImGui::GetFontSize(), height = ImGui::GetFrameHeight();
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const bool is_pressed = ImGui::InvisibleButton("play", {button_width * line, height});
    const ImU32 colour = ImGui::GetColorU32(ImGui::IsItemHovered() ? ImGuiCol_Text : ImGuiCol_SliderGrabActive);
    ImDrawList& drawn = *ImGui::GetWindowDrawList();
    const float top = at.y + 0.5f * (height - line) + 0.1f * line, size = 0.8f * line;
    if (is_paused) {
        drawn.AddTriangleFilled({at.x, top}, {at.x + size, top + 0.5f * size}, {at.x, top + size}, colour);
    } else {
        drawn.AddRectFilled({at.x, top}, {at.x + 0.3f * size, top + size}, colour);
        drawn.AddRectFilled({at.x + 0.55f * size, top}, {at.x + 0.85f * size, top + size}, colour);
    }
    return is_pressed;
}

}  // namespace

bool is_offered(const ShownSetting& setting, std::string_view word, const FaceContent& content) {
    if (setting.section == PanelSection::exposure)
        return content.has_hdr;
    return setting.name != "method" || word != "eye-depth" || content.has_geometry;
}

bool Face::is_awake() const {
    return content_.shown.panel || asks_for_source_ || shows_about_ || !content_.has_picture || has_menu_open() ||
           sought_s_ || seconds_since(moved_) < awake_s;
}

bool Face::takes(const KeyEvent& key) const {
    const bool closes = key.key == GLFW_KEY_ESCAPE && (shows_about_ || has_menu_open());
    return has_keyboard() || closes;
}

void Face::feed(const InputEvent& event) {
    if (const auto* pointer = std::get_if<PointerEvent>(&event)) {
        if (!pointer_ || pointer_->x != pointer->x || pointer_->y != pointer->y)
            moved_ = Clock::now();
        pointer_ = *pointer;
    }
    if (std::holds_alternative<ButtonEvent>(event))
        moved_ = Clock::now();
    if (const auto* key = std::get_if<KeyEvent>(&event);
        key != nullptr && key->is_down && key->key == GLFW_KEY_ESCAPE && takes(*key)) {
        if (has_menu_open())
            ImGui::ClosePopupToLevel(0, false);
        asks_for_source_ = shows_about_ = false;
    }
    gui_.feed(event, [this] { build(); });
}

void Face::say(FaceContent content) {
    if (content.has_picture && !content_.has_picture)
        moved_ = Clock::now();
    content_ = std::move(content);
}

std::optional<PointerEvent> Face::pointer_over_picture() const {
    return pointer_ && !has_pointer() ? pointer_ : std::nullopt;
}

void Face::ask_for_source() {
    asks_for_source_ = true;
    source_text_.clear();
}

void Face::choose(const ShownSetting& setting, std::string value) {
    wish(SettingWish{&setting, std::move(value)});
}

void Face::draw() {
    gui_.draw([this] { build(); });
}

void Face::build() {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    // Always the same, so that what stands there does not move when the bars come.
    Room room{menu_bar_height(), window.y - timeline_height()};
    float right = window.x, bottom = window.y;
    if (is_awake()) {
        build_menu_bar();
        build_timeline();
        bottom = room.bottom;
    }
    if (content_.shown.panel && content_.has_picture)
        right = build_panel(room);
    build_warning(bottom);
    if (!content_.shown.panel)
        build_legend(content_, right, room.bottom);
    if (content_.shown.times && !graph_.is_empty())
        graph_.build(room.top, right, content_.decoder);
    if (help_page_ > 0)
        build_help(room);
    if (!content_.has_picture)
        build_loading();
    if (asks_for_source_)
        build_source_field();
    if (shows_about_)
        build_about();
}

void Face::build_warning(float bottom) {
    std::string words = content_.warning;
    if (content_.has_picture && !content_.loading.empty())
        words = "loading " + content_.loading;
    if (words.empty())
        return;
    ImGui::SetNextWindowPos({0, bottom}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowBgAlpha(face_alpha);
    ImGui::Begin("warning", nullptr, plain_window);
    ImGui::PushTextWrapPos(ImGui::GetIO().DisplaySize.x - face_margin());
    ImGui::TextColored(warning_colour, "%s", words.c_str());
    ImGui::PopTextWrapPos();
    ImGui::End();
}

void Face::build_loading() {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0.5f * window.x, 0.5f * window.y}, ImGuiCond_Always, {0.5f, 0.5f});
    ImGui::SetNextWindowBgAlpha(0);
    ImGui::Begin("loading", nullptr, plain_window);
    ImGui::PushTextWrapPos(0.9f * window.x);
    text(content_.loading.empty() ? "Drop a stream, a 360 video or a folder of frames here (or press Ctrl+O)"
                                  : "loading " + content_.loading);
    ImGui::PopTextWrapPos();
    ImGui::End();
}

// Time.

void Face::build_timeline() {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({0, window.y}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowSize({window.x, timeline_height()});
    ImGui::SetNextWindowBgAlpha(face_alpha);
    ImGui::Begin("timeline", nullptr, fixed_window | ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse);
    if (content_.has_picture) {
        build_bar();
        if (build_play_button(content_.is_paused))
            wish(Action::play_pause);
        ImGui::SameLine();
        ImGui::AlignTextToFramePadding();
        std::string line = content_.is_live ? "live" : clock_text(content_.time_s - content_.timeline.first_s);
        if (content_.timeline.is_known())
            line += " / " + clock_text(content_.timeline.seconds);
        text(line + formatted("   frame %lld", static_cast<long long>(content_.frame)));
        if (!content_.is_live) {
            ImGui::SameLine();
            bool loops = content_.shown.loop;
            if (ImGui::Checkbox("loop", &loops))
                wish(Action::loop);
        }
        ImGui::SameLine(0, 1.5f * ImGui::GetFontSize());
        text(content_.status);
    }
    ImGui::End();
}

/// Clicked or dragged along, it seeks, where the length of what is shown is known.
void Face::build_bar() {
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const ImVec2 size(std::max(1.0f, ImGui::GetContentRegionAvail().x), bar_height * ImGui::GetFontSize());
    const TimelineBar bar{corner.x, size.x};
    const Timeline& timeline = content_.timeline;
    ImGui::InvisibleButton("time", size);
    const bool can_seek = timeline.is_known() && !content_.is_live;
    if (can_seek && ImGui::IsItemActive()) {
        const double time_s = time_at(timeline, bar, ImGui::GetIO().MousePos.x);
        if (sought_s_ != time_s)
            wish(SeekWish{time_s});
        sought_s_ = time_s;
    } else {
        sought_s_.reset();
    }
    const float done = timeline.is_known() ? place_of(timeline, bar, sought_s_.value_or(content_.time_s)) - bar.left
                                           : bar.width * float(content_.is_live ? 1.0 : content_.fraction_done);
    ImDrawList& drawn = *ImGui::GetWindowDrawList();
    const float bottom = corner.y + size.y;
    drawn.AddRectFilled(corner, {corner.x + size.x, bottom}, ImGui::GetColorU32(ImGuiCol_FrameBg));
    drawn.AddRectFilled(corner, {corner.x + done, bottom}, ImGui::GetColorU32(ImGuiCol_SliderGrab));
    if (can_seek) {
        const float half = 0.15f * ImGui::GetFontSize();
        drawn.AddRectFilled({corner.x + done - half, corner.y}, {corner.x + done + half, bottom}, IM_COL32_WHITE);
        if (ImGui::IsItemHovered())
            ImGui::SetTooltip("%s",
                              clock_text(time_at(timeline, bar, ImGui::GetIO().MousePos.x) - timeline.first_s).c_str());
    }
}

// Keys.

/// The page of the keys that is wanted, in the room that is left.
void Face::build_help(const Room& room) {
    const float margin = face_margin();
    ImGui::SetNextWindowPos({margin, room.top + margin});
    ImGui::SetNextWindowBgAlpha(keys_alpha);
    ImGui::Begin("keys", nullptr, plain_window);
    const ImGuiStyle& style = ImGui::GetStyle();
    const float line = ImGui::GetTextLineHeightWithSpacing();
    float names = 0;
    for (const KeyBinding& b : key_bindings())
        names = std::max(names, ImGui::CalcTextSize(b.name.data(), b.name.data() + b.name.size()).x);
    names += ImGui::GetFontSize();
    const float wrap = ImGui::GetIO().DisplaySize.x - 2 * margin - 2 * style.WindowPadding.x - names;
    const float page_height = room.bottom - room.top - 2 * margin - 2 * style.WindowPadding.y - line;
    int page = 1;
    float used = 0;
    std::string_view task;
    for (const KeyBinding& b : key_bindings()) {
        const char* const end = b.help.data() + b.help.size();
        const float height = ImGui::CalcTextSize(b.help.data(), end, false, wrap).y + style.ItemSpacing.y;
        const bool turns = used > 0 && used + height + (b.task != task ? line : 0) > page_height;
        page += turns;
        used = turns ? 0 : used;
        const bool has_heading = b.task != task || turns;
        used += height + (has_heading ? line : 0);
        task = b.task;
        if (page != help_page_)
            continue;
        if (has_heading)
            ImGui::TextColored(heading_colour, "%.*s", int(b.task.size()), b.task.data());
        text(b.name);
        ImGui::SameLine(style.WindowPadding.x + names);
        ImGui::PushTextWrapPos(style.WindowPadding.x + names + wrap);
        ImGui::TextUnformatted(b.help.data(), end);
        ImGui::PopTextWrapPos();
    }
    if (page > 1)
        ImGui::TextColored(heading_colour, "page %d of %d (h: next)", help_page_, page);
    ImGui::End();
    if (help_page_ > page)
        help_page_ = 0;
}

// A source's name, as it is typed.

void Face::build_source_field() {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    const float width = std::min(source_field_width * ImGui::GetFontSize(), 0.9f * window.x);
    ImGui::SetNextWindowPos({0.5f * (window.x - width), menu_bar_height() + face_margin()});
    ImGui::SetNextWindowSize({width, 0});
    ImGui::Begin("open", nullptr, fixed_window & ~ImGuiWindowFlags_NoBringToFrontOnFocus);
    text("A file, a folder, or a server's address (tcp://HOST:PORT)");
    ImGui::SetNextItemWidth(-1);
    if (!ImGui::IsAnyItemActive())
        ImGui::SetKeyboardFocusHere();
    const bool is_entered = ImGui::InputText("##source", &source_text_, ImGuiInputTextFlags_EnterReturnsTrue);
    const bool is_opened = ImGui::Button("Open");
    ImGui::SameLine();
    const bool is_cancelled = ImGui::Button("Cancel");
    if ((is_entered || is_opened) && !trimmed(source_text_).empty())
        wish(OpenWish{std::string(trimmed(source_text_))});
    if (is_entered || is_opened || is_cancelled)
        asks_for_source_ = false;
    ImGui::End();
}

}  // namespace equistream
