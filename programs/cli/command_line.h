#pragma once
/// A program's options, by CLI11 underneath. Its headers take seconds to compile, so only this folder includes them.
#include <functional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace equistream::cli {

/// One option: a handle, good until run_program returns.
class Option {
public:
    Option() = default;  ///< none: only to be assigned to
    explicit Option(CLI::Option* option) : option_(option) {}

    // Each returns the same option.
    Option required() const;
    /// --help shows the value that the variable has now.
    Option with_default() const;
    Option with_default(const std::string& text) const;
    Option one_of(const std::vector<std::string>& words) const;
    /// --help shows these words, or what these rows call `name`, and completion offers them. The program itself checks
    /// what is given.
    template <typename Words>
    Option offers(const Words& words) const {
        std::string set;
        for (const auto& word : words) {
            set += set.empty() ? "" : ",";
            if constexpr (requires { word.name; })
                set += word.name;
            else
                set += word;
        }
        return type_name("{" + set + "}");
    }
    /// Both count as inside.
    template <typename Number>
    Option between(Number least, Number most) const;
    Option existing_file() const;
    Option existing_folder() const;
    Option excludes(Option other) const;
    /// The heading of --help that it stands under; hidden by an empty one.
    Option group(const std::string& name) const;
    Option type_name(const std::string& name) const;
    /// So many words at once.
    Option expected(int words) const;
    /// It takes one word each time that it is given.
    Option one_word_each_time() const;
    Option description(const std::string& text) const;

    bool is_given() const;
    std::string name() const;
    std::string group() const;

private:
    CLI::Option* option_ = nullptr;
};

/// What a program, or a subcommand of it, may be given: a handle too.
class CommandLine {
public:
    explicit CommandLine(CLI::App& app) : app_(&app) {}

    /// `name`: "--out", "-D,--define", or "SCENE" for what stands alone. `value`, which must outlive the parsing, is
    /// set where the option is given. command_line.cpp lists the types that it may have.
    template <typename Value>
    Option add_option(const std::string& name, Value& value, const std::string& description);
    Option add_function(const std::string& name, std::function<void(const std::string&)> take,
                        const std::string& description);
    Option add_flag(const std::string& name, bool& value, const std::string& description);

    CommandLine add_subcommand(const std::string& name, const std::string& description);
    /// Exactly one of them.
    void require_subcommand();
    /// What --help ends with.
    void footer(const std::string& text);

    /// Whether the option is on the command line or in the file of --settings.
    bool is_given(const std::string& option) const;
    /// Whether it is the subcommand that was chosen.
    bool is_chosen() const;
    std::vector<Option> options() const;

private:
    CLI::App* app_;
};

}  // namespace equistream::cli
