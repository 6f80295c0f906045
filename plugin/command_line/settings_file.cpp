#include "settings_file.h"

#include <equistream/error.h>

#include <algorithm>
#include <sstream>

namespace equistream::cli {

namespace {

std::string trimmed(const std::string& text) {
    const auto first = text.find_first_not_of(" \t\r\"'");
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r\"'") - first + 1);
}

/// Where a key or the section [key] is first spoken of; CLI11 does not keep it. 0 where it cannot be found.
int line_of(const std::string& text, const std::string& key) {
    std::istringstream lines(text);
    std::string section;
    int number = 1;
    for (std::string line; std::getline(lines, line); ++number) {
        line = trimmed(line);
        if (line.starts_with('[')) {
            section = trimmed(line.substr(1, line.find(']') - 1));
            if (section == key)
                return number;
            section += '.';
        } else if (section + trimmed(line.substr(0, line.find('='))) == key) {
            return number;
        }
    }
    return 0;
}

bool is_accepted(const CLI::Option& option) {
    return option.get_configurable() && !option.get_lnames().empty();
}

/// As _parse_single_config looks them up.
bool knows(const CLI::App& app, const std::string& name) {
    for (const std::string& spelling : {"--" + name, "-" + name, name})
        if (const CLI::Option* option = app.get_option_no_throw(spelling))
            return option->get_configurable();
    return name == "++" || name == "--";  // a section's begin and end
}

const CLI::App* subcommand(const CLI::App& app, const std::string& name) {
    const auto subs = app.get_subcommands([&](const CLI::App* sub) { return sub->check_name(name); });
    return subs.empty() ? nullptr : subs.front();
}

std::string accepted_names(const CLI::App& app) {
    std::string names;
    for (const CLI::Option* option : app.get_options())
        if (is_accepted(*option))
            names += (names.empty() ? "" : ", ") + option->get_lnames().front();
    return "one of " + names;
}

}  // namespace

std::vector<CLI::ConfigItem> SettingsFile::from_config(std::istream& input) const {
    std::ostringstream whole;
    whole << input.rdbuf();
    std::istringstream again(whole.str());
    const std::vector<CLI::ConfigItem> found = ConfigBase::from_config(again);
    for (const CLI::ConfigItem& item : found) {
        const CLI::App* app = &app_;
        std::string key;
        for (const std::string& section : item.parents) {
            key += (key.empty() ? "" : ".") + section;
            app = app != nullptr ? subcommand(*app, section) : nullptr;
        }
        if (app != nullptr && knows(*app, item.name))
            continue;
        if (app != nullptr)
            key = item.fullname();
        const int line = line_of(whole.str(), key);
        throw InputError(expected_found(
            app_.get_config_ptr()->as<std::string>() + (line > 0 ? ":" + std::to_string(line) : std::string()),
            app != nullptr ? accepted_names(*app) : "options outside any section", "'" + key + "'"));
    }
    return found;
}

}  // namespace equistream::cli
