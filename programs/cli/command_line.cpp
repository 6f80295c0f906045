#include "command_line.h"

#include <equistream/text.h>

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <system_error>
#include <type_traits>
#include <utility>

namespace equistream::cli {

namespace {

/// CLI11 takes an empty word for 0, and 010 for 8, and finds NaN in every range.
template <typename Value>
std::string unless_a_number(const std::string& word) {
    if (word.empty())
        return "expected a number, found ''";
    if (std::is_floating_point_v<Value> && std::isnan(std::strtod(word.c_str(), nullptr)))
        return "expected a number, found '" + word + "'";
    const std::size_t begin = word.find_first_not_of("+-");
    const bool is_octal = std::is_integral_v<Value> && begin != word.npos && begin + 1 < word.size() &&
                          word[begin] == '0' && word.find_first_not_of("0123456789", begin) == word.npos;
    return is_octal ? "expected a number without leading zeros, found '" + word + "'" : "";
}

/// `check`, which --help describes, with a refusal in our words: good(word), or what was expected.
template <typename Good>
CLI::Validator told(CLI::Validator check, Good good, const std::string& expected) {
    check.operation([good, expected](std::string& word) {
        return good(word) ? std::string() : "expected " + expected + ", found '" + word + "'";
    });
    return check;
}

CLI::Validator existing(CLI::Validator check, bool is_folder) {
    check.operation([is_folder](std::string& word) {
        std::error_code error;
        if (!std::filesystem::exists(word, error))
            return std::string("expected ") + (is_folder ? "a folder" : "a file") + ", found none: '" + word + "'";
        if (std::filesystem::is_directory(word, error) == is_folder)
            return std::string();
        return is_folder ? "expected a folder, found a file: '" + word + "'"
                         : "expected a file, found a folder: '" + word + "'";
    });
    return check;
}

template <typename Value>
CLI::Option* add(CLI::App& app, const std::string& name, Value& value, const std::string& description) {
    CLI::Option* option = app.add_option(name, value, description);
    return std::is_arithmetic_v<Value> ? option->check(unless_a_number<Value>) : option;
}

template <typename Number>
CLI::Option* add(CLI::App& app, const std::string& name, std::optional<Number>& value, const std::string& description) {
    return app
        .add_option_function<Number>(
            name, [&value](const Number& given) { value = given; }, description)
        ->check(unless_a_number<Number>);
}

}  // namespace

Option Option::required() const {
    return Option(option_->required());
}

Option Option::with_default() const {
    return Option(option_->capture_default_str());
}

Option Option::with_default(const std::string& text) const {
    return Option(option_->default_str(text));
}

Option Option::one_of(const std::vector<std::string>& words) const {
    const auto is_one = [words](const std::string& word) { return std::ranges::find(words, word) != words.end(); };
    return Option(option_->check(told(CLI::IsMember(words), is_one, in_a_sentence(words, " or "))));
}

template <typename Number>
Option Option::between(Number least, Number most) const {
    const auto is_within = [least, most](const std::string& word) {
        Number value{};
        return CLI::detail::lexical_cast(word, value) && value >= least && value <= most;
    };
    const std::string kind = std::is_integral_v<Number> ? "a whole number" : "a number";
    const std::string limits = " from " + in_words(double(least)) + " to " + in_words(double(most));
    return Option(option_->check(told(CLI::Range(least, most), is_within, kind + limits)));
}

template Option Option::between(int, int) const;
template Option Option::between(unsigned, unsigned) const;
template Option Option::between(std::int64_t, std::int64_t) const;
template Option Option::between(double, double) const;

Option Option::existing_file() const {
    return Option(option_->check(existing(CLI::ExistingFile, false)));
}

Option Option::existing_folder() const {
    return Option(option_->check(existing(CLI::ExistingDirectory, true)));
}

Option Option::excludes(Option other) const {
    return Option(option_->excludes(other.option_));
}

Option Option::group(const std::string& name) const {
    return Option(option_->group(name));
}

Option Option::type_name(const std::string& name) const {
    return Option(option_->type_name(name));
}

Option Option::expected(int words) const {
    return Option(option_->expected(words));
}

Option Option::one_word_each_time() const {
    return Option(option_->allow_extra_args(false));
}

Option Option::description(const std::string& text) const {
    return Option(option_->description(text));
}

bool Option::is_given() const {
    return option_->count() > 0;
}

std::string Option::name() const {
    return option_->get_name();
}

std::string Option::group() const {
    return option_->get_group();
}

template <typename Value>
Option CommandLine::add_option(const std::string& name, Value& value, const std::string& description) {
    return Option(add(*app_, name, value, description));
}

template Option CommandLine::add_option(const std::string&, std::string&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::filesystem::path&, const std::string&);
template Option CommandLine::add_option(const std::string&, int&, const std::string&);
template Option CommandLine::add_option(const std::string&, unsigned&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::int64_t&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::uint64_t&, const std::string&);
template Option CommandLine::add_option(const std::string&, double&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::optional<int>&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::optional<unsigned>&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::optional<double>&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::vector<std::string>&, const std::string&);
template Option CommandLine::add_option(const std::string&, std::vector<std::filesystem::path>&, const std::string&);

Option CommandLine::add_function(const std::string& name, std::function<void(const std::string&)> take,
                                 const std::string& description) {
    return Option(app_->add_option_function<std::string>(name, std::move(take), description));
}

Option CommandLine::add_flag(const std::string& name, bool& value, const std::string& description) {
    return Option(app_->add_flag(name, value, description));
}

CommandLine CommandLine::add_subcommand(const std::string& name, const std::string& description) {
    return CommandLine(*app_->add_subcommand(name, description));
}

void CommandLine::require_subcommand() {
    app_->require_subcommand(1);
}

void CommandLine::footer(const std::string& text) {
    app_->footer(text);
}

bool CommandLine::is_given(const std::string& option) const {
    return app_->count(option) > 0;
}

bool CommandLine::is_chosen() const {
    return app_->parsed();
}

std::vector<Option> CommandLine::options() const {
    std::vector<Option> options;
    for (CLI::Option* option : app_->get_options())
        options.emplace_back(option);
    return options;
}

}  // namespace equistream::cli
