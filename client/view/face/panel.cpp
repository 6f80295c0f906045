/// The panel: settings and values under their headings.
#include "face.h"
#include "legend.h"
#include "parts.h"

#include <equistream/text.h>

#include <algorithm>

namespace equistream {

namespace {

/// In lines of text.
constexpr float panel_width = 25, values_from = 9;
constexpr float max_share = 0.7f;  ///< of the window's width

/// What the menus have too, or few ask for, is folded.
bool is_open_at_first(PanelSection section, bool is_live) {
    return section == PanelSection::source || section == PanelSection::method || section == PanelSection::overlay ||
           section == PanelSection::exposure || section == PanelSection::mouse ||
           (section == PanelSection::network && is_live);
}

std::string capitalised(std::string_view words) {
    std::string text(words);
    if (!text.empty() && text[0] >= 'a' && text[0] <= 'z')
        text[0] = char(text[0] - 'a' + 'A');
    return text;
}

}  // namespace

/// A slider for a number, a tick for a switch, a list for words.
void Face::build_setting(const ShownSetting& setting) {
    const std::string value = setting.value(content_.shown), label(setting.label);
    if (setting.words.empty()) {
        auto number = float(parsed_number(value).value_or(0));
        const std::string format = "%+.2f " + std::string(setting.unit);
        ImGui::SetNextItemWidth(panel_width * 0.5f * ImGui::GetFontSize());
        if (ImGui::SliderFloat(label.c_str(), &number, float(setting.least), float(setting.most), format.c_str()))
            choose(setting, in_words(double(number)));
        return;
    }
    if (setting.is_switch() && setting.parts.empty()) {
        bool is_on = value == "on";
        if (ImGui::Checkbox(label.c_str(), &is_on))
            choose(setting, is_on ? "on" : "off");
        return;
    }
    ImGui::SetNextItemWidth(panel_width * 0.5f * ImGui::GetFontSize());
    if (ImGui::BeginCombo(label.c_str(), value.c_str())) {
        for (const std::string_view word : setting.words)
            if (is_offered(setting, word, content_) &&
                ImGui::Selectable(std::string(word).c_str(), word == std::string_view(value)))
                choose(setting, std::string(word));
        ImGui::EndCombo();
    }
    if (!setting.parts.empty())
        build_passes(setting);
}

/// The parts of a list, each with its tick.
void Face::build_passes(const ShownSetting& setting) {
    ShownSettings whole = content_.shown;
    const std::string now = setting.value(whole);
    if (now == "off")
        return;
    const std::string list = now == "on" ? default_fill : now;
    const auto parts = split_at_commas(list);
    const auto has = [&](std::string_view part) { return std::ranges::find(parts, part) != parts.end(); };
    for (const std::string_view part : setting.parts) {
        bool is_chosen = has(part);
        if (!ImGui::Checkbox(std::string(part).c_str(), &is_chosen))
            continue;
        std::string chosen;
        for (const std::string_view each : setting.parts)
            if (each == part ? is_chosen : has(each))
                chosen += (chosen.empty() ? "" : ",") + std::string(each);
        choose(setting, chosen.empty() ? "off" : chosen);
    }
}

void Face::build_section(PanelSection section) {
    const auto settings = shown_settings();
    const bool has_settings = std::ranges::any_of(settings, [&](const ShownSetting& setting) {
        return setting.section == section && is_offered(setting, {}, content_);
    });
    const bool has_facts = std::ranges::any_of(content_.facts, [&](const Fact& f) { return f.section == section; });
    const std::string heading = capitalised(panel_section_names[std::size_t(section)]);
    const ImGuiTreeNodeFlags flags =
        is_open_at_first(section, content_.is_live) ? ImGuiTreeNodeFlags_DefaultOpen : ImGuiTreeNodeFlags_None;
    if ((!has_settings && !has_facts) || !ImGui::CollapsingHeader(heading.c_str(), flags))
        return;
    ImGui::PushID(int(section));
    for (const ShownSetting& setting : settings)
        if (setting.section == section && is_offered(setting, {}, content_))
            build_setting(setting);
    const float line = ImGui::GetFontSize();
    for (const Fact& fact : content_.facts) {
        if (fact.section != section)
            continue;
        ImGui::TextDisabled("%.*s", int(fact.label.size()), fact.label.data());
        ImGui::SameLine(values_from * line);
        ImGui::PushTextWrapPos(0);
        text(fact.value);
        ImGui::PopTextWrapPos();
    }
    if (section == PanelSection::overlay)
        build_legend_items(content_);
    ImGui::PopID();
}

/// Where its left border is.
float Face::build_panel(const Room& room) {
    const float window = ImGui::GetIO().DisplaySize.x;
    const float width = std::min(panel_width * ImGui::GetFontSize(), max_share * window);
    ImGui::SetNextWindowPos({window - width, room.top});
    ImGui::SetNextWindowSize({width, std::max(1.0f, room.bottom - room.top)});
    ImGui::SetNextWindowBgAlpha(face_alpha);
    ImGui::Begin("panel", nullptr, fixed_window);
    for (std::size_t section = 0; section < panel_section_names.size(); ++section)
        build_section(PanelSection(section));
    ImGui::End();
    return window - width;
}

}  // namespace equistream
