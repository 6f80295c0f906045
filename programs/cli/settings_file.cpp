#include "settings_file.h"

#include "commands.h"
#include "settings_text.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

namespace equistream::cli {

namespace {

constexpr std::size_t max_settings_bytes = 1 << 20;

bool is_mark(const CLI::ConfigItem& item) {
    return item.name == "++" || item.name == "--";  // a section's begin and end
}

std::string bare(const std::string& text) {
    const auto first = text.find_first_not_of(" \t\r\"'");
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\"'") - first + 1);
}

/// Where a key or the section [key] is spoken of; CLI11 does not keep it.
std::vector<int> lines_of(const std::string& text, const std::string& key) {
    std::istringstream lines(text);
    std::string section;
    std::vector<int> found;
    int number = 1;
    for (std::string line; std::getline(lines, line); ++number) {
        line = bare(line);
        if (line.starts_with('[')) {
            section = bare(line.substr(1, line.find(']') - 1));
            if (section == key)
                found.push_back(number);
            section += '.';
        } else if (section + bare(line.substr(0, line.find('='))) == key) {
            found.push_back(number);
        }
    }
    return found;
}

/// As _parse_single_config looks it up. Null: there is none of this name for a file.
const CLI::Option* option_of(const CLI::App& app, const std::string& name) {
    for (const std::string& spelling : {"--" + name, "-" + name, name})
        if (const CLI::Option* option = app.get_option_no_throw(spelling))
            return option->get_configurable() ? option : nullptr;
    return nullptr;
}

const CLI::App* subcommand(const CLI::App& app, const std::string& name) {
    const auto subs = app.get_subcommands([&](const CLI::App* sub) { return sub->check_name(name); });
    return subs.empty() ? nullptr : subs.front();
}

/// Whether the command line gives another option in its place. What the file gives is not counted yet.
bool is_replaced(const CLI::Option& option) {
    return std::ranges::any_of(option.get_excludes(), [](const CLI::Option* other) { return other->count() > 0; });
}

std::vector<std::string> accepted_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        if (option->get_configurable() && !option->get_lnames().empty())
            names.push_back(option->get_lnames().front());
    return names;
}

/// "scene" of equistream scene.
std::string section_of(const CLI::App& app) {
    return app.get_name().substr(app.get_name().rfind(' ') + 1);
}

/// The sections of a command that has subcommands and no options of its own; else a word for none.
std::string sections_of(const CLI::App& app) {
    std::vector<std::string> sections;
    for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; }))
        sections.push_back("[" + section_of(app) + "." + sub->get_name() + "]");
    return sections.empty() ? "another section" : in_a_sentence(sections, " or ");
}

/// Reads lines of option = value as CLI11 does. Lines in the section of a command, [play] say, are that command's
/// alone, so that one file serves several. A key that `app` has no option for is an InputError that names file, line
/// and the options there are.
class SettingsFile : public CLI::ConfigBase {
public:
    SettingsFile(const CLI::App& app, SettingsPlaces& places) : app_(app), places_(places) {
        comment('\x1f');  // remarks have gone before it looks
    }
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
        std::string whole(max_settings_bytes + 1, '\0');  // of a device without an end no more is read
        input.read(whole.data(), std::streamsize(whole.size()));
        whole.resize(std::size_t(input.gcount()));
        if (whole.size() > max_settings_bytes)
            throw InputError(expected_found("--settings " + file(), "a file of at most 1 MiB", "more bytes"));
        const std::string text = without_byte_order_mark(whole);
        std::istringstream again(settings_for_reader(text, file()));
        const std::string own = section_of(app_);
        std::vector<CLI::ConfigItem> accepted;
        std::vector<bool> is_own;  // of each: said for this command alone
        for (CLI::ConfigItem& item : ConfigBase::from_config(again)) {
            const std::string section = item.parents.empty() ? "" : item.parents.front();
            if (section != own && std::ranges::find(commands, section, &Command::name) != commands.end())
                continue;
            const std::string name = item.fullname();
            if (section == own) {
                item.parents.erase(item.parents.begin());
                if (is_mark(item) && item.parents.empty())
                    continue;
            }
            if (const CLI::Option* option = known(item, name, text)) {
                if (is_replaced(*option))
                    continue;
                keep_place(*option, item, lines_of(text, name));
            }
            // What is said for a command alone wins. CLI11 takes an option's values from one item.
            const auto said = std::ranges::find_if(accepted, [&](const CLI::ConfigItem& other) {
                return !is_mark(item) && other.parents == item.parents && other.name == item.name;
            });
            if (said == accepted.end()) {
                accepted.push_back(std::move(item));
                is_own.push_back(section == own);
                continue;
            }
            std::vector<bool>::reference was_own = is_own[std::size_t(said - accepted.begin())];
            if (was_own == (section == own)) {
                said->inputs.insert(said->inputs.end(), item.inputs.begin(), item.inputs.end());
            } else if (section == own) {
                *said = std::move(item);
                was_own = true;
            }
        }
        return accepted;
    }

private:
    std::string file() const { return app_.get_config_ptr()->as<std::string>(); }

    /// The first of `lines`, where there is one.
    std::string place(const std::vector<int>& lines) const {
        return lines.empty() ? file() : file() + ":" + std::to_string(lines.front());
    }

    /// The option that the item gives; null for a section's mark. `name` is its name with its section's, as in the
    /// file's `text`.
    const CLI::Option* known(const CLI::ConfigItem& item, const std::string& name, const std::string& text) const {
        const CLI::App* app = &app_;
        std::string section;
        for (const std::string& parent : item.parents) {
            section += (section.empty() ? "" : ".") + parent;
            app = app != nullptr ? subcommand(*app, parent) : nullptr;
        }
        if (app == nullptr) {
            std::array<std::string_view, commands.size()> names;
            std::ranges::transform(commands, names.begin(), &Command::name);
            throw InputError(
                expected_found(place(lines_of(text, section)), "a command's name in brackets", "'[" + section + "]'") +
                did_you_mean(section, names));
        }
        if (is_mark(item))
            return nullptr;
        if (const CLI::Option* option = option_of(*app, item.name))
            return option;
        const std::vector<std::string> names = accepted_names(*app);
        if (names.empty())
            throw InputError(
                expected_found(place(lines_of(text, name)), "options of " + sections_of(*app), "'" + name + "'"));
        throw InputError(
            expected_found(place(lines_of(text, name)), "one of " + in_a_sentence(names, ", "), "'" + name + "'") +
            did_you_mean(item.name, names));
    }

    /// `lines`: where the file gives it.
    void keep_place(const CLI::Option& option, const CLI::ConfigItem& item, const std::vector<int>& lines) const {
        const bool takes_one = option.get_expected_max() <= 1;
        if (takes_one && lines.size() > 1)
            throw InputError(expected_found(place({lines[1]}), item.name + " once",
                                            "it again, after line " + std::to_string(lines[0])));
        if (takes_one && item.inputs.size() > 1)
            throw InputError(
                expected_found(place(lines), "one value of " + item.name, std::to_string(item.inputs.size())));
        const CLI::App* of = item.parents.empty() ? nullptr : subcommand(app_, item.parents.front());
        if (option.count() == 0 && !option.get_lnames().empty() && (of == nullptr || of->parsed()))
            places_[option.get_lnames().front()] = place(lines);
    }

    const CLI::App& app_;  // it owns us
    SettingsPlaces& places_;
};

}  // namespace

std::shared_ptr<CLI::Config> settings_file(const CLI::App& app, SettingsPlaces& places) {
    return std::make_shared<SettingsFile>(app, places);
}

std::string with_place(const std::string& message, const SettingsPlaces& places) {
    if (!message.starts_with("--"))
        return message;
    const std::string_view name = std::string_view(message).substr(2, message.find_first_of(": =", 2) - 2);
    const auto found = places.find(name);
    return found == places.end() ? message : found->second + ": " + message;
}

}  // namespace equistream::cli
