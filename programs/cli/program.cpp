#include "program.h"

#include "help_formatter.h"
#include "parse_errors.h"
#include "process.h"
#include "settings_file.h"

#include <client/transport/address.h>
#include <equistream/error.h>
#include <equistream/image.h>

#include <CLI/CLI.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <limits>
#include <new>
#include <string>
#include <utility>

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

/// Where one of them was closed, the next file that is opened would take its number, and what is said would be written
/// into that file. What is written to these fails, as it would where they are closed. Without /dev/null they stay
/// closed.
void hold_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        if (fcntl(stream, F_GETFD) < 0)
            static_cast<void>(open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
}

std::array<char, 80> out_of_memory_line;  // made while there is memory

/// Nothing is thrown through libraries: where it leaves one of their threads, the others may wait for it for ever.
[[noreturn]] void end_without_memory() {
    static std::atomic_flag is_ending;
    while (is_ending.test_and_set())
        pause();
    [[maybe_unused]] const ssize_t written =
        write(STDERR_FILENO, out_of_memory_line.data(), std::strlen(out_of_memory_line.data()));
    _exit(exit_failed);
}

}  // namespace

void end_where_memory_ends(const std::string& name) {
    std::snprintf(out_of_memory_line.data(), out_of_memory_line.size(), "equistream %s: out of memory\n", name.c_str());
    std::set_new_handler(end_without_memory);
}

int run_program(int argc, char** argv, const ProgramText& text,
                const std::function<std::function<void()>(CommandLine&)>& setup) {
    const std::string& name = text.name;
    std::signal(SIGXFSZ, SIG_IGN);  // write() then says why
    hold_standard_streams();
    SettingsPlaces places;
    CLI::App app(text.summary, "equistream " + name);
    app.set_version_flag("--version", std::string("equistream ") + EQUISTREAM_VERSION);
    app.set_config("--settings", "", "Read options from a file: lines of option = value (command line wins)")
        ->type_name("FILE");
    app.config_formatter(settings_file(app, places));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.footer("Example:\n  " + text.example + "\n\nExit status: 0 done, 1 failed, 2 bad usage or input.");
    app.formatter(help_formatter());
    CommandLine command_line(app);
    const auto refuse = [&](const std::string& message) {
        return report(name, with_place(message, places), exit_usage);
    };
    try {
        const auto run = setup(command_line);
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& e) {
            if (e.get_exit_code() == 0)
                return app.exit(e);
            return refuse(explained(app, e));
        }
        run();
        if (std::fflush(stdout) != 0 || std::ferror(stdout))
            return report(name, "standard output: could not be written", exit_failed);
        return exit_done;
    } catch (const ChildFailed& child) {
        return child.exit_code;
    } catch (const InputError& e) {
        return refuse(e.what());
    } catch (const std::bad_alloc&) {
        return report(name, "out of memory", exit_failed);
    } catch (const std::exception& e) {
        report(name, e.what(), exit_failed);
        end_by_noted_interrupt();
        return exit_failed;
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

void add_former_name(CommandLine& app, const std::string& command, const std::string& former, const std::string& name,
                     double& value) {
    app.add_function(
           former,
           [command, former, name, &value](const std::string& text) {
               const std::optional<double> number = parsed_number(text);
               require(number.has_value() && !std::isnan(*number), former, "a number", in_quotes(text));
               std::fprintf(stderr, "equistream %s: note: %s is now called %s\n", command.c_str(), former.c_str(),
                            name.c_str());
               value = *number;
           },
           "")
        .group("");
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
