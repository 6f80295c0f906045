#include "parse_errors.h"

#include "commands.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <CLI/CLI.hpp>

#include <cctype>
#include <filesystem>
#include <system_error>
#include <vector>

namespace equistream::cli {

namespace {

void add_names(const CLI::App& app, std::vector<std::string>& names) {
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty())
            for (const std::string& name : option->get_lnames())
                names.push_back("--" + name);
}

/// "-o" is short for the shortest option that begins with the letter.
std::string meant_by_letter(char letter, const std::vector<std::string>& names) {
    std::string shortest;
    for (const std::string& name : names)
        if (name[2] == letter && (shortest.empty() || name.size() < shortest.size()))
            shortest = name;
    return shortest.empty() ? "" : "; did you mean " + shortest + "?";
}

/// Of the parsed words that no option takes, the first option: what it may have been meant to be. Empty: there is none.
std::string unknown_option(const CLI::App& app) {
    for (const std::string& word : app.remaining(true)) {
        const bool is_long = word.starts_with("--") && word.size() > 2;
        const bool is_short = word.size() > 1 && word[0] == '-' && std::isalpha(static_cast<unsigned char>(word[1]));
        if (!is_long && !is_short)
            continue;
        const std::string name = word.substr(0, word.find('='));
        const std::vector<CLI::App*> chosen = app.get_subcommands();
        if (!chosen.empty() && app.get_option_no_throw(name) != nullptr)
            return name + ": expected before " + chosen.front()->get_name();
        std::vector<std::string> names;
        add_names(app, names);
        for (const CLI::App* subcommand : app.get_subcommands())
            add_names(*subcommand, names);
        return name + ": no such option" +
               (name.size() == 2 ? meant_by_letter(name[1], names) : did_you_mean(name, names));
    }
    return "";
}

/// Of the subcommand that was chosen, or of the program itself. Null: there is none of this name.
const CLI::Option* option_called(const CLI::App& app, const std::string& name) {
    for (const CLI::App* subcommand : app.get_subcommands())
        if (const CLI::Option* option = subcommand->get_option_no_throw(name))
            return option;
    return app.get_option_no_throw(name);
}

/// `said`: "Could not convert: --crf = abc".
std::string not_converted(const CLI::App& app, const std::string& said) {
    constexpr std::string_view begin = "Could not convert: ", between = " = ";
    const std::size_t end = said.find(between);
    if (!said.starts_with(begin) || end == said.npos)
        return said;
    const std::string name = said.substr(begin.size(), end - begin.size());
    const std::string found = "'" + said.substr(end + between.size()) + "'";
    const CLI::Option* option = option_called(app, name);
    if (option != nullptr && option->get_items_expected_max() == 0)
        return expected_found(name, "true or false", found);
    const std::string type = option != nullptr ? option->get_type_name() : "";
    const bool is_whole = type.starts_with("INT") || type.starts_with("UINT");
    return expected_found(name, is_whole ? "a whole number" : "a number", found);
}

/// `said`: "--out: 1 required TEXT missing".
std::string miscounted(const CLI::App& app, const std::string& said) {
    const std::string name = said.substr(0, said.find(": "));
    const CLI::Option* option = option_called(app, name);
    if (option == nullptr)
        return said;
    const auto values = [](int count) { return count == 1 ? "one value" : std::to_string(count) + " values"; };
    const int found = int(option->results().size());
    const bool is_too_many = found > option->get_items_expected_max();
    return expected_found(name,
                          values(is_too_many ? option->get_items_expected_max() : option->get_items_expected_min()),
                          found == 0 ? "none" : std::to_string(found));
}

std::string unreadable_settings(const CLI::App& app) {
    const auto file = app.get_config_ptr()->as<std::string>();
    std::error_code error;
    const char* found = std::filesystem::is_directory(file, error) ? "a folder"
                        : std::filesystem::exists(file, error)     ? "one that cannot be read"
                                                                   : "none";
    return expected_found("--settings " + file, "a file of settings", found);
}

std::string without_subcommand(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::App* subcommand : app.get_subcommands([](const CLI::App*) { return true; }))
        names.push_back(subcommand->get_name());
    std::string found = "none";
    for (const std::string& word : app.remaining(true))
        if (found == "none" && !word.starts_with('-'))
            found = quotable("'" + word + "'", 300) + did_you_mean(word, names);
    return "expected " + in_a_sentence(names, " or ") + ", found " + found;
}

std::string in_our_words(const CLI::App& app, const CLI::ParseError& error) {
    const std::string said = error.what();
    if (dynamic_cast<const CLI::FileError*>(&error) != nullptr)
        return unreadable_settings(app);
    if (dynamic_cast<const CLI::ConversionError*>(&error) != nullptr)
        return not_converted(app, said);
    if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr)
        return miscounted(app, said);
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && said == "A subcommand is required")
        return without_subcommand(app);
    const std::vector<std::string> further = app.remaining(true);
    if (dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr && !further.empty())
        return "expected no further words, found " + quotable("'" + further.front() + "'", 300);
    return said;
}

}  // namespace

std::string explained(const CLI::App& app, const CLI::ParseError& error) {
    const std::string unknown = unknown_option(app);
    return (unknown.empty() ? in_our_words(app, error) : unknown) + " (--help lists the options)";
}

}  // namespace equistream::cli
