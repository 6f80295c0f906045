#include "stage_graph.h"
#include "parts.h"

#include <algorithm>
#include <array>
#include <numeric>

namespace equistream {

namespace {

constexpr std::array<ImU32, gl::render_stage_names.size()> stage_colours = {
    IM_COL32(120, 120, 120, 255), IM_COL32(70, 130, 230, 255), IM_COL32(60, 190, 200, 255), IM_COL32(80, 190, 90, 255),
    IM_COL32(235, 180, 40, 255),  IM_COL32(170, 90, 210, 255), IM_COL32(220, 90, 80, 255)};

/// In lines of text.
constexpr float graph_width = 24, graph_height = 8, values_from = 7;

double sum(const gl::StageTimes::Row& row) {
    return std::accumulate(row.begin(), row.end(), 0.0);
}

}  // namespace

void StageGraph::add(const gl::StageTimes::Row& row, double refresh_ms) {
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

void StageGraph::build(float top, float right, const std::string& decoder) const {
    const float line = ImGui::GetFontSize(), margin = face_margin();
    ImGui::SetNextWindowPos({right - margin, top + margin}, ImGuiCond_Always, {1, 0});
    ImGui::SetNextWindowBgAlpha(face_alpha);
    ImGui::Begin("times", nullptr, plain_window);
    double max_ms = 1;
    for (const gl::StageTimes::Row& row : rows_)
        max_ms = std::max(max_ms, sum(row));
    const ImVec2 corner = ImGui::GetCursorScreenPos(), size(graph_width * line, graph_height * line);
    ImGui::Dummy(size);
    const float step = size.x / float(max_rows);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const gl::StageTimes::Row& row = rows_[(newest_ + 1 + i) % rows_.size()];
        const float x = corner.x + step * float(i);
        float y = corner.y + size.y;
        for (std::size_t stage = 0; stage < row.size(); ++stage) {
            const float above = y - size.y * float(row[stage] / max_ms);
            ImGui::GetWindowDrawList()->AddRectFilled({x, above}, {x + step, y}, stage_colours[stage]);
            y = above;
        }
    }
    const gl::StageTimes::Row& last = rows_[newest_];
    ImGui::Text("%.1f of %.1f ms a refresh; graph height %.1f ms", sum(last), refreshes_ms_[newest_], max_ms);
    for (std::size_t stage = 0; stage < last.size(); ++stage) {
        ImGui::TextColored(ImColor(stage_colours[stage]), "%s", gl::render_stage_names[stage].data());
        ImGui::SameLine(values_from * line);
        ImGui::Text("%.2f ms", last[stage]);
    }
    if (!decoder.empty()) {
        ImGui::TextUnformatted("decoder");
        ImGui::SameLine(values_from * line);
        ImGui::TextUnformatted(decoder.c_str());
    }
    ImGui::End();
}

}  // namespace equistream
