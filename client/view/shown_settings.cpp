#include "shown_settings.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <client/fill/gl/fill_pass.h>
#include <client/stages/stages.h>
#include <equistream/colour.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace equistream {

namespace {

using Notes = std::vector<std::string>;
using Words = std::vector<std::string_view>;

const Words off_or_on = {"off", "on"};

std::size_t place_of(const ShownSetting& setting, const std::string& word) {
    const auto found = std::ranges::find(setting.words, word);
    if (found == setting.words.end())
        throw InputError(
            expected_found("--" + std::string(setting.name), in_a_sentence(setting.words, ", "), "'" + word + "'"));
    return std::size_t(found - setting.words.begin());
}

/// A row of `words`, which stand for the member's values from 0 on.
template <typename Value>
ShownSetting row_of(Value ShownSettings::*member, ShownSetting row) {
    row.value = [member, words = row.words](const ShownSettings& shown) {
        return std::string(words[std::size_t(shown.*member)]);
    };
    row.set = [member, words = ShownSetting{.name = row.name, .words = row.words}](ShownSettings& shown,
                                                                                   const std::string& word) {
        shown.*member = Value(place_of(words, word));
        return Notes{};
    };
    return row;
}

ShownSetting method_row() {
    Words methods;
    for (const EngineStage& engine : engine_stages())
        if (engine.on_gpu)
            methods.push_back(engine.name);
    return {.name = "method",
            .label = "Method",
            .section = PanelSection::method,
            .menu = SettingMenu::picture,
            .key = Action::next_method,
            .words = methods,
            .has_default = false,
            .help = "How the eyes' pictures are made. Default: eye-depth with --scene or --model, else mesh where the "
                    "stream has depth, else rotation" +
                    described(engine_stages(), true),
            .value =
                [](const ShownSettings& shown) {
                    return !shown.by_depth ? "rotation" : shown.by_geometry ? "eye-depth" : shown.engine;
                },
            .set =
                [](ShownSettings& shown, const std::string& word) {
                    const EngineStage& engine = find_engine(word);
                    if (!engine.on_gpu)
                        throw InputError(expected_found("--method " + std::string(engine.name),
                                                        "a method of the viewer", "one of play only"));
                    shown.by_depth = engine.finds_depth || engine.needs.any();
                    if (shown.by_depth)
                        shown.by_geometry = !engine.finds_depth;
                    if (engine.finds_depth)
                        shown.engine = engine.name;
                    const std::string note = renamed_note(engine, word, "--method");
                    return note.empty() ? Notes{} : Notes{note};
                },
            .next_value =
                [](const ShownSettings& shown) {
                    return shown.by_depth ? "rotation" : shown.by_geometry ? "eye-depth" : shown.engine;
                },
            .behind_name = "method-by-depth",
            .behind = [](const ShownSettings& shown) { return shown.engine; }};
}

ShownSetting anaglyph_row() {
    Words names;
    for (const Anaglyph& kind : anaglyphs())
        names.push_back(kind.name);
    return {.name = "anaglyph",
            .label = "Anaglyph",
            .section = PanelSection::layout,
            .menu = SettingMenu::view,
            .key = Action::next_anaglyph,
            .words = names,
            .help = "Colours for red and cyan glasses",
            .value = [](const ShownSettings& shown) { return std::string(shown.anaglyph->name); },
            .set =
                [](ShownSettings& shown, const std::string& word) {
                    shown.anaglyph = &find_anaglyph(word);
                    return Notes{};
                }};
}

ShownSetting mirrors_row() {
    const auto names = mirror_treatment_names();
    return row_of(&ShownSettings::mirrors,
                  {.name = "mirrors",
                   .label = "Mirrors and glass",
                   .section = PanelSection::reflections,
                   .menu = SettingMenu::picture,
                   .words = {names.begin(), names.end()},
                   .help = "How methods with depth show mirrors and glass. images: at the depth of their virtual "
                           "image; gaps: left as gaps, for --fill; surface: as if painted on the surface"});
}

ShownSetting fill_row() {
    Words passes;
    for (const FillStage& pass : fill_stages())
        if (pass.on_gpu)
            passes.push_back(pass.name);
    const auto chain_of = [](const ShownSettings& shown) {
        return shown.fill_chain == default_fill ? std::string("on") : shown.fill_chain;
    };
    return {.name = "fill",
            .label = "Fill gaps",
            .section = PanelSection::fill,
            .menu = SettingMenu::picture,
            .key = Action::fill,
            .words = off_or_on,
            .parts = passes,
            .help = "Passes that fill gaps, in order, separated by commas. on: " + std::string(default_fill) +
                    ". off: gaps stay black" + described(fill_stages(), true),
            .value = [=](const ShownSettings& shown) { return shown.fill ? chain_of(shown) : std::string("off"); },
            .set =
                [](ShownSettings& shown, const std::string& word) {
                    Notes notes;
                    std::string chain = word == "off" ? shown.fill_chain : default_fill;
                    if (word != "on" && word != "off")
                        chain = gl::with_passes_of_gpu(word, notes);
                    parse_fills(chain);  // says which words are accepted
                    shown.fill = word != "off";
                    shown.fill_chain = chain;
                    return notes;
                },
            .next_value = [=](const ShownSettings& shown) { return shown.fill ? std::string("off") : chain_of(shown); },
            .behind_name = "fill-passes",
            .behind = chain_of};
}

ShownSetting exposure_row() {
    return {.name = "exposure",
            .label = "Exposure",
            .section = PanelSection::exposure,
            .menu = SettingMenu::picture,
            .option = SettingOption::none,  // play has it too, with the other settings of HDR
            .is_kept = false,               // it is the stream's
            .least = -max_exposure_stops,
            .most = max_exposure_stops,
            .unit = "stops",
            .value = [](const ShownSettings& shown) { return in_words(shown.exposure_stops); },
            .set =
                [](ShownSettings& shown, const std::string& word) {
                    const std::optional<double> stops = parsed_number(word);
                    if (!(stops && std::abs(*stops) <= max_exposure_stops))
                        throw InputError(expected_found("--exposure", "stops from -20 to 20", "'" + word + "'"));
                    shown.exposure_stops = *stops;
                    return Notes{};
                }};
}

std::vector<ShownSetting> make_rows() {
    const auto words_of = [](const auto& names) { return Words(names.begin(), names.end()); };
    return {
        method_row(),
        row_of(&ShownSettings::layout, {.name = "layout",
                                        .label = "Layout",
                                        .section = PanelSection::layout,
                                        .menu = SettingMenu::view,
                                        .key = Action::next_layout,
                                        .words = words_of(gl::display_layout_names),
                                        .help = "Which eyes the window shows, and how"}),
        anaglyph_row(),
        row_of(&ShownSettings::overlay, {.name = "overlay",
                                         .label = "Overlay",
                                         .section = PanelSection::overlay,
                                         .menu = SettingMenu::view,
                                         .key = Action::next_overlay,
                                         .words = words_of(gl::overlay_names),
                                         .help = "What is laid over the picture"}),
        mirrors_row(),
        fill_row(),
        exposure_row(),
        row_of(&ShownSettings::loop, {.name = "loop",
                                      .label = "Start again at the end",
                                      .section = PanelSection::source,
                                      .menu = SettingMenu::time,
                                      .key = Action::loop,
                                      .words = off_or_on,
                                      .help = "on: starts again at the end; off: stays there"}),
        row_of(&ShownSettings::times, {.name = "times",
                                       .label = "Times by stage",
                                       .section = PanelSection::speed,
                                       .menu = SettingMenu::view,
                                       .option = SettingOption::flag,
                                       .key = Action::times,
                                       .words = off_or_on,
                                       .help = "Show frame times by stage (t)"}),
        row_of(&ShownSettings::panel, {.name = "panel",
                                       .label = "Panel",
                                       .section = PanelSection::layout,
                                       .menu = SettingMenu::view,
                                       .option = SettingOption::flag,
                                       .key = Action::panel,
                                       .words = off_or_on,
                                       .help = "Show the panel of settings and values (tab)"}),
    };
}

}  // namespace

std::string ShownSetting::next(const ShownSettings& shown) const {
    if (next_value)
        return next_value(shown);
    return std::string(words[(place_of(*this, value(shown)) + 1) % words.size()]);
}

std::span<const ShownSetting> shown_settings() {
    static const std::vector<ShownSetting> rows = make_rows();
    return rows;
}

const ShownSetting* find_shown_setting(std::string_view name) {
    const auto found = std::ranges::find(shown_settings(), name, &ShownSetting::name);
    return found == shown_settings().end() ? nullptr : &*found;
}

const ShownSetting* shown_setting_of(Action key) {
    const auto found = std::ranges::find(shown_settings(), std::optional(key), &ShownSetting::key);
    return found == shown_settings().end() ? nullptr : &*found;
}

}  // namespace equistream
