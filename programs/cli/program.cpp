#include "program.h"

#include "commands.h"
#include "process.h"
#include "settings_text.h"

#include <client/transport/address.h>
#include <equistream/error.h>
#include <equistream/image.h>

#include <CLI/CLI.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <new>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace equistream::cli {

namespace {

/// The whole of `text` as a number, digits only.
template <typename Integer>
bool read_whole(std::string_view text, Integer& value) {
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    return result.ec == std::errc() && result.ptr == end;
}

std::string in_quotes(std::string_view text) {
    return "'" + std::string(text) + "'";
}

/// Errors are one line, whatever a library or a file's name put into its message.
std::string one_line(std::string text) {
    text.erase(text.find_last_not_of('\n') + 1);
    std::ranges::replace(text, '\n', ' ');
    const std::size_t all = text.size();
    return quotable(std::move(text), all);
}

int report(const std::string& name, const std::string& message, int code) {
    std::fprintf(stderr, "equistream %s: %s\n", name.c_str(), one_line(message).c_str());
    return code;
}

void add_names(const CLI::App& app, std::vector<std::string>& names) {
    for (const CLI::Option* option : app.get_options())
        if (!option->get_group().empty())
            for (const std::string& name : option->get_lnames())
                names.push_back("--" + name);
}

/// Of the parsed words that no option takes, the first option: what it may have been meant to be. Empty: there is none.
std::string unknown_option(const CLI::App& app) {
    for (const std::string& word : app.remaining(true)) {
        if (!word.starts_with("--") || word.size() < 3)
            continue;
        const std::string name = word.substr(0, word.find('='));
        std::vector<std::string> names;
        add_names(app, names);
        for (const CLI::App* subcommand : app.get_subcommands())
            add_names(*subcommand, names);
        return name + ": no such option" + did_you_mean(name, names);
    }
    return "";
}

std::string explained(const CLI::App& app, const CLI::ParseError& error) {
    const std::string unknown = unknown_option(app);
    return (unknown.empty() ? error.what() : unknown) + " (--help lists the options)";
}

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

/// Two spaces at least stand between an option and what it means: CLI11 would leave one where the option just fits.
class Columns : public CLI::Formatter {
public:
    std::string make_option(const CLI::Option* option, bool is_positional) const override {
        std::string name = make_option_name(option, is_positional) + make_option_opts(option);
        constexpr std::size_t margin = 2;
        if (margin + name.size() + 1 == column_width_)
            name += ' ';  // what is as long as the column gets a line of its own
        std::ostringstream out;
        CLI::detail::format_help(out, name, make_option_desc(option), column_width_);
        return out.str();
    }
};

// The file that --settings names.

/// Reads lines of option = value as CLI11 does. Lines in the section of a command, [play] say, are that command's
/// alone, so that one file serves several. A key that `app` has no option for is an InputError that names file, line
/// and the options there are.
class SettingsFile : public CLI::ConfigBase {
public:
    explicit SettingsFile(const CLI::App& app) : app_(app) { comment('\x1f'); }  // remarks have gone before it looks
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override {
        std::ostringstream whole;
        whole << input.rdbuf();
        std::istringstream again(settings_for_reader(whole.str(), app_.get_config_ptr()->as<std::string>()));
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

private:
    /// `place` is its name with its section's, as in the file's `text`.
    void require_known(const CLI::ConfigItem& item, const std::string& place, const std::string& text) const {
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

    const CLI::App& app_;  // it owns us
};

/// Where one of them was closed, the next file that is opened would take its number, and what is said would be written
/// into that file. What is written to these fails, as it would where they are closed. Without /dev/null they stay
/// closed.
void hold_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0)
            static_cast<void>(open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
}

}  // namespace

int run_program(int argc, char** argv, const ProgramText& text,
                const std::function<std::function<void()>(CommandLine&)>& setup) {
    const std::string& name = text.name;
    std::signal(SIGXFSZ, SIG_IGN);  // write() then says why
    hold_standard_streams();
    CLI::App app(text.summary, "equistream " + name);
    app.set_version_flag("--version", std::string("equistream ") + EQUISTREAM_VERSION);
    app.set_config("--settings", "", "Read options from a file: lines of option = value (command line wins)")
        ->type_name("FILE");
    app.config_formatter(std::make_shared<SettingsFile>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.footer("Example:\n  " + text.example + "\n\nExit status: 0 done, 1 failed, 2 bad usage or input.");
    app.formatter(std::make_shared<Columns>());
    app.get_formatter()->column_width(34);
    CommandLine command_line(app);
    try {
        const auto run = setup(command_line);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& e) {
            if (e.get_exit_code() == 0)
                return app.exit(e);
            return report(name, explained(app, e), exit_usage);
        }
        run();
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            return report(name, "standard output: could not be written", exit_failed);
        return exit_done;
    } catch (const ChildFailed& child) {
        return child.exit_code;
    } catch (const InputError& e) {
        return report(name, e.what(), exit_usage);
    } catch (const std::bad_alloc&) {
        return report(name, "out of memory", exit_failed);
    } catch (const std::exception& e) {
        return report(name, e.what(), exit_failed);
    }
}

void require(bool good, const std::string& option, const std::string& expected, const std::string& found) {
    if (!good)
        throw InputError(expected_found(option, expected, found));
}

Size parse_size(const std::string& text, const std::string& option) {
    const std::size_t x = text.find('x');
    Size size;
    const bool good = x != std::string::npos && read_whole(std::string_view(text).substr(0, x), size.width) &&
                      read_whole(std::string_view(text).substr(x + 1), size.height) && size.width >= 1 &&
                      size.height >= 1 && size.width <= max_image_side && size.height <= max_image_side;
    require(good, option, "WxH, each 1 to " + std::to_string(max_image_side), in_quotes(text));
    return size;
}

FrameRange parse_frames(const std::string& text) {
    const std::size_t dash = text.find('-', 1);
    FrameRange range;
    bool good = read_whole(std::string_view(text).substr(0, dash), range.first);
    range.last = range.first;
    if (dash != std::string::npos)
        good = good && read_whole(std::string_view(text).substr(dash + 1), range.last);
    require(good && range.first >= 0, "--frames", "FIRST-LAST or one frame number, from 0", in_quotes(text));
    require(range.last >= range.first, "--frames", "the last frame not before the first", in_quotes(text));
    require(range.last < std::numeric_limits<std::int32_t>::max(), "--frames", "frame numbers below 2147483647",
            in_quotes(text));
    return range;
}

Option add_frames_option(CommandLine& app, std::optional<FrameRange>& frames, const std::string& description) {
    return app.add_function(
        "--frames", [&frames](const std::string& text) { frames = parse_frames(text); }, description);
}

Option add_seed_option(CommandLine& app, std::uint64_t& seed, const std::string& description) {
    return app
        .add_function(
            "--seed",
            [&seed](const std::string& text) {
                require(read_whole(text, seed), "--seed", "a whole number from 0 to 18446744073709551615",
                        in_quotes(text));
            },
            description)
        .type_name("UINT")
        .with_default(std::to_string(seed));
}

Option add_json_flag(CommandLine& app, bool& json) {
    return app.add_flag("--json", json, "Report as JSON on standard output");
}

Option add_progress_option(CommandLine& app, std::string& progress) {
    return app
        .add_option("--progress", progress,
                    "auto: a bar on a terminal; json: a line of JSON a step on standard error; none: nothing")
        .with_default()
        .offers(std::array{"auto", "json", "none"});
}

void hide_secret(std::string& source) {
    const auto address = parse_server_address(source);
    if (!address || address->secret.empty())
        return;
    setenv(secret_variable, address->secret.c_str(), 1);
    source = address->text();
}

std::string quoted_command(int argc, char** argv) {
    const std::string program = argc > 0 ? argv[0] : "";
    std::string command = program.substr(program.rfind('/') + 1);
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        command += ' ';
        const bool plain =
            !word.empty() && word.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                                    "0123456789_-+=.,:/@%") == std::string::npos;
        if (plain) {
            command += word;
            continue;
        }
        command += '\'';
        for (const char c : word)
            command += c == '\'' ? std::string("'\\''") : std::string(1, c);
        command += '\'';
    }
    return command;
}

}  // namespace equistream::cli
