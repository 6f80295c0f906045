#include "panels.h"
#include "keys.h"

#include <client/view/gl/display.h>
#include <equistream/text.h>

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace equistream {

namespace {

constexpr ImGuiWindowFlags plain = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                   ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoFocusOnAppearing |
                                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_AlwaysAutoResize;
constexpr float margin = 10;
const ImVec2 graph_size{360, 120};
/// The letters are pictures of 13 rows, which lose strokes at any scale but whole ones.
constexpr int rows_a_scale = 1080;
constexpr float key_columns = 13;  // of the widest key's name, and one

constexpr std::array<ImU32, gl::render_stage_names.size()> stage_colours = {
    IM_COL32(120, 120, 120, 255), IM_COL32(70, 130, 230, 255), IM_COL32(60, 190, 200, 255), IM_COL32(80, 190, 90, 255),
    IM_COL32(235, 180, 40, 255),  IM_COL32(170, 90, 210, 255), IM_COL32(220, 90, 80, 255)};

double sum(const gl::StageTimes::Row& row) {
    return std::accumulate(row.begin(), row.end(), 0.0);
}

/// How high it is.
float build_status(const StatusLine& status) {
    const ImGuiIO& io = ImGui::GetIO();
    ImGui::SetNextWindowPos({0, io.DisplaySize.y}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowSize({io.DisplaySize.x, 0});
    ImGui::SetNextWindowBgAlpha(0.55f);
    ImGui::Begin("status", nullptr, plain & ~ImGuiWindowFlags_AlwaysAutoResize);
    if (!status.warning.empty())
        ImGui::TextColored({1, 0.6f, 0.3f, 1}, "%s", status.warning.c_str());
    ImGui::TextUnformatted(status.text.c_str());
    ImGui::ProgressBar(float(status.fraction_done), {-1, 4}, "");
    const float height = ImGui::GetWindowHeight();
    ImGui::End();
    return height;
}

void draw_legend(const std::string& legend) {
    const ImVec2 window = ImGui::GetIO().DisplaySize;
    constexpr int above = gl::motion_legend.from_bottom + gl::motion_legend.radius;
    ImGui::SetNextWindowPos({window.x - margin, window.y - margin - float(above)}, ImGuiCond_Always, {1, 1});
    ImGui::SetNextWindowBgAlpha(0.55f);
    ImGui::Begin("legend", nullptr, plain);
    ImGui::TextUnformatted(legend.c_str());
    ImGui::End();
}

}  // namespace

int text_scale(gl::Size window) {
    return std::max(1, window.height / rows_a_scale);
}

Panels::Panels() {
    IMGUI_CHECKVERSION();
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsDark();
    ImGui_ImplOpenGL3_Init("#version 450 core");
}

Panels::~Panels() {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext();
}

void Panels::add(const gl::StageTimes::Row& row, double refresh_ms) {
    if (rows_.size() < max_rows) {
        rows_.reserve(max_rows);
        refreshes_ms_.reserve(max_rows);
        newest_ = rows_.size();
        rows_.push_back(row);
        refreshes_ms_.push_back(refresh_ms);
        return;
    }
    newest_ = (newest_ + 1) % max_rows;
    rows_[newest_] = row;
    refreshes_ms_[newest_] = refresh_ms;
}

/// The page of the keys that is wanted, in a height of `room`.
void Panels::build_help(float room) {
    ImGui::SetNextWindowPos({margin, margin});
    ImGui::SetNextWindowBgAlpha(0.8f);
    ImGui::Begin("keys", nullptr, plain);
    const ImGuiStyle& style = ImGui::GetStyle();
    const float line = ImGui::GetTextLineHeightWithSpacing(), names = key_columns * ImGui::CalcTextSize("m").x;
    const float wrap = ImGui::GetIO().DisplaySize.x - 2 * margin - 2 * style.WindowPadding.x - names;
    const float page_height = room - 2 * margin - 2 * style.WindowPadding.y - line;
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
            ImGui::TextColored({1, 0.85f, 0.4f, 1}, "%.*s", int(b.task.size()), b.task.data());
        ImGui::Text("%.*s", int(b.name.size()), b.name.data());
        ImGui::SameLine(style.WindowPadding.x + names);
        ImGui::PushTextWrapPos(style.WindowPadding.x + names + wrap);
        ImGui::TextUnformatted(b.help.data(), end);
        ImGui::PopTextWrapPos();
    }
    if (page > 1)
        ImGui::TextColored({1, 0.85f, 0.4f, 1}, "page %d of %d (h: on)", help_page_, page);
    ImGui::End();
    if (help_page_ > page)
        help_page_ = 0;
}

void Panels::build_times(const std::string& decoder) const {
    ImGui::SetNextWindowPos({ImGui::GetIO().DisplaySize.x - margin, margin}, ImGuiCond_Always, {1, 0});
    ImGui::SetNextWindowBgAlpha(0.8f);
    ImGui::Begin("times", nullptr, plain);
    double max_ms = 1;
    for (const gl::StageTimes::Row& row : rows_)
        max_ms = std::max(max_ms, sum(row));
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    ImGui::Dummy(graph_size);
    const float step = graph_size.x / float(max_rows);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const gl::StageTimes::Row& row = rows_[(newest_ + 1 + i) % rows_.size()];
        const float x = corner.x + step * float(i);
        float y = corner.y + graph_size.y;
        for (std::size_t stage = 0; stage < row.size(); ++stage) {
            const float top = y - graph_size.y * float(row[stage] / max_ms);
            ImGui::GetWindowDrawList()->AddRectFilled({x, top}, {x + step, y}, stage_colours[stage]);
            y = top;
        }
    }
    const gl::StageTimes::Row& last = rows_[newest_];
    ImGui::Text("%.1f ms of %.1f ms a refresh; the graph is %.1f ms high", sum(last), refreshes_ms_[newest_], max_ms);
    for (std::size_t stage = 0; stage < last.size(); ++stage)
        ImGui::TextColored(ImColor(stage_colours[stage]), "%-12s %7.2f ms", gl::render_stage_names[stage].data(),
                           last[stage]);
    if (!decoder.empty())
        ImGui::Text("decoder      %s", decoder.c_str());
    ImGui::End();
}

void Panels::build(const StatusLine& status, bool with_times) {
    const float status_height = build_status(status);
    if (!status.legend.empty())
        draw_legend(status.legend);
    if (with_times && !rows_.empty())
        build_times(status.decoder);
    if (help_page_ > 0)
        build_help(ImGui::GetIO().DisplaySize.y - status_height);
}

void Panels::draw(const StatusLine& status, gl::Size window, bool with_times) {
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::GetIO().FontGlobalScale = float(text_scale(window));
    // Nothing here takes keys, and events are another thread's.
    ImGui::GetIO().DisplaySize = {float(window.width), float(window.height)};
    // Panels take the size of what was in them the time before, and nothing may be drawn for long after this.
    for (int i = 0; i < 2; ++i) {
        if (i > 0)
            ImGui::EndFrame();
        ImGui::NewFrame();
        build(status, with_times);
    }
    ImGui::Render();
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace equistream
