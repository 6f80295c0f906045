#pragma once
/// What a viewer shows of a source and how, as it may be changed while it runs: one table. A setting's option, its key,
/// its place in menus and panel and its name in the file of settings come from its row.
#include "keys.h"

#include <client/fill/fill.h>
#include <client/reflections/specular.h>
#include <client/view/gl/display.h>
#include <client/warp/gl/eye_depth_finder.h>

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace equistream {

struct ShownSettings {
    gl::DisplayLayout layout = gl::DisplayLayout::left;
    const Anaglyph* anaglyph = &anaglyphs().front();
    gl::Overlay overlay = gl::Overlay::none;
    bool by_depth = true;
    bool by_geometry = false;                        ///< depth is that of the scene's geometry, where there is one
    std::string engine{gl::default_finding_engine};  ///< finds depth without geometry
    bool fill = true;
    std::string fill_chain = default_fill;  ///< that gaps are filled by, where they are
    MirrorTreatment mirrors = MirrorTreatment::images;
    double exposure_stops = 0;  ///< of HDR pictures
    bool loop = true, times = false, panel = false;

    bool operator==(const ShownSettings&) const = default;
};

/// The panel's headings, in their order.
enum class PanelSection { method, layout, overlay, fill, reflections, exposure, mouse, source, network, speed };
inline constexpr std::array<std::string_view, 10> panel_section_names = {
    "method", "layout", "overlay", "fill", "reflections", "exposure", "mouse", "source", "network", "speed"};

/// Where the menu bar has a setting.
enum class SettingMenu { none, view, picture, time };

/// How a command line sets it.
enum class SettingOption { none, word, flag };

struct ShownSetting {
    std::string_view name{};   ///< of its option, without dashes, and in the file of settings
    std::string_view label{};  ///< in menus and panel
    PanelSection section = PanelSection::layout;
    SettingMenu menu = SettingMenu::none;
    SettingOption option = SettingOption::word;
    std::optional<Action> key{};            ///< whose press chooses next()
    bool is_kept = true;                    ///< from one run to the next
    std::vector<std::string_view> words{};  ///< that menus offer; empty: it is a number
    std::vector<std::string_view> parts{};  ///< of a list that it may be besides: in this order, between commas
    double least = 0, most = 0;             ///< of a number
    std::string_view unit{};                ///< the same
    bool has_default = true;                ///< which --help shows
    std::string help{};                     ///< of its option

    /// As its option takes it.
    std::function<std::string(const ShownSettings&)> value{};
    /// Throws InputError that names the option and the accepted words. Notes on what was taken otherwise than given.
    std::function<std::vector<std::string>(ShownSettings&, const std::string&)> set{};
    /// What its key changes it to; null: the word after the one that it is.
    std::function<std::string(const ShownSettings&)> next_value{};
    /// What the value hides while something else is shown: its name in the file of settings, and the word that `set`
    /// takes. Null: the value hides nothing.
    std::string_view behind_name{};
    std::function<std::string(const ShownSettings&)> behind{};

    std::string next(const ShownSettings& shown) const;
    bool is_switch() const { return words.size() == 2 && words[0] == "off" && words[1] == "on"; }
};

/// In the order of --help.
std::span<const ShownSetting> shown_settings();
/// Null where there is none.
const ShownSetting* find_shown_setting(std::string_view name);
const ShownSetting* shown_setting_of(Action key);

}  // namespace equistream
