#include "settings_file.h"
#include "commands.h"
#include "did_you_mean.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <algorithm>
#include <sstream>
#include <utility>

namespace equistream::cli {

namespace {

bool is_mark(const CLI::ConfigItem& item) {
    return item.name == "++" || item.name == "--";  // a section's begin and end
}

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
    return false;
}

const CLI::App* subcommand(const CLI::App& app, const std::string& name) {
    const auto subs = app.get_subcommands([&](const CLI::App* sub) { return sub->check_name(name); });
    return subs.empty() ? nullptr : subs.front();
}

std::vector<std::string> accepted_names(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        if (is_accepted(*option))
            names.push_back(option->get_lnames().front());
    return names;
}

}  // namespace

std::vector<CLI::ConfigItem> SettingsFile::from_config(std::istream& input) const {
    std::ostringstream whole;
    whole << input.rdbuf();
    std::istringstream again(whole.str());
    const std::string own = app_.get_name().substr(app_.get_name().rfind(' ') + 1);
    std::vector<CLI::ConfigItem> accepted;
    for (CLI::ConfigItem& item : ConfigBase::from_config(again)) {
        const std::string section = item.parents.size() == 1 ? item.parents.front() : "";
        if (section != own && std::ranges::find(commands, section, &Command::name) != commands.end())
            continue;
        const std::string place = item.fullname();
        if (section == own)
            item.parents.clear();
        if (is_mark(item) && section == own)
            continue;
        require_known(item, place, whole.str());
        // What is said for a command alone wins.
        if (section == own)
            std::erase_if(accepted, [&](const CLI::ConfigItem& other) {
                return other.parents.empty() && other.name == item.name;
            });
        accepted.push_back(std::move(item));
    }
    return accepted;
}

void SettingsFile::require_known(const CLI::ConfigItem& item, const std::string& place, const std::string& text) const {
    const CLI::App* app = &app_;
    std::string key;
    for (const std::string& section : item.parents) {
        key += (key.empty() ? "" : ".") + section;
        app = app != nullptr ? subcommand(*app, section) : nullptr;
    }
    if (app != nullptr && (is_mark(item) || knows(*app, item.name)))
        return;
    if (app != nullptr)
        key = place;
    const int line = line_of(text, key);
    const std::string where =
        app_.get_config_ptr()->as<std::string>() + (line > 0 ? ":" + std::to_string(line) : std::string());
    if (app == nullptr)
        throw InputError(expected_found(where, "options outside any section but of a command's", "'" + key + "'"));
    const std::vector<std::string> names = accepted_names(*app);
    throw InputError(expected_found(where, "one of " + in_a_sentence(names, ", "), "'" + key + "'") +
                     did_you_mean(item.name, names));
}

}  // namespace equistream::cli
