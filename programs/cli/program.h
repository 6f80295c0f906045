#pragma once
/// What every program shares: exit codes, one-line errors, --settings, progress, common option values.
#include "command_line.h"

#include <equistream/elapsed.h>
#include <equistream/text.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace equistream::cli {

/// Exit codes of every command.
inline constexpr int exit_done = 0;
inline constexpr int exit_failed = 1;
inline constexpr int exit_usage = 2;

/// What --help says: the command's name, one sentence on what it does, a command line to start from.
struct ProgramText {
    std::string name, summary, example;
};

/// Parses, runs and turns exceptions into one line on stderr ("equistream render: ...") and an exit code:
/// InputError and CLI errors 2, anything else 1. `setup` adds options to the app and returns what to run.
/// Adds --settings FILE (TOML/INI as CLI11 reads it), --help, --version. A file that grows beyond the limit of its size
/// (ulimit -f) is an error where it is written, not the end of the process by SIGXFSZ.
int run_program(int argc, char** argv, const ProgramText& text,
                const std::function<std::function<void()>(CommandLine&)>& setup);

/// Throws InputError "OPTION: expected EXPECTED, found FOUND" unless it is good.
void require(bool good, const std::string& option, const std::string& expected, const std::string& found);

/// The place of an option's word among those that it may be. Throws InputError that lists these.
template <typename Value = std::size_t, typename Words>
Value parse_word(const std::string& option, const std::string& word, const Words& words,
                 std::string_view before_last = " or ") {
    const auto found = std::ranges::find(words, word);
    require(found != std::end(words), option, in_a_sentence(words, before_last), "'" + word + "'");
    return Value(found - std::begin(words));
}

/// An option whose default is shown by --help. `words`: what it may be, where that is one of a few.
template <typename Value>
Option add_with_default(CommandLine& app, const std::string& name, Value& value, const std::string& description,
                        const std::vector<std::string>& words = {}) {
    Option option = app.add_option(name, value, description).with_default();
    return words.empty() ? option : option.one_of(words);
}

struct Size {
    int width = 0;
    int height = 0;
};
Size parse_size(const std::string& text, const std::string& option = "--size");  ///< "960x480"

struct FrameRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
};
FrameRange
parse_frames(const std::string& text);  ///< "0-149" or "7"; empty, negative or backward ranges are InputErrors

/// Adds --frames, which sets `frames` when it is given.
Option add_frames_option(CommandLine& app, std::optional<FrameRange>& frames, const std::string& description);

/// Adds --seed: a whole number from 0 to 2^64 - 1, exactly; anything else is refused.
Option add_seed_option(CommandLine& app, std::uint64_t& seed, const std::string& description);

/// Adds the name that the number's option `name` had in earlier versions. Help does not list it; where it is given,
/// `command` says on stderr what it is called now. Added before that option, which then wins where both are given.
void add_former_name(CommandLine& app, const std::string& command, const std::string& former, const std::string& name,
                     double& value);

/// The command line as one shell-quoted string, for manifests and reports; the program without its folder.
std::string quoted_command(int argc, char** argv);

/// Puts the secret of a server's address into the environment, where connections look for it, so that what is said of
/// the source does not say it.
void hide_secret(std::string& source);

enum class ProgressStyle { automatic, json, none };
/// Adds --json: the report on standard output is JSON and nothing else.
Option add_json_flag(CommandLine& app, bool& json);

/// Adds --progress, whose value parse_progress() reads.
Option add_progress_option(CommandLine& app, std::string& progress);

/// "auto" (a bar on a terminal, nothing elsewhere), "json" (a line per step on stderr), "none".
ProgressStyle parse_progress(const std::string& text);

/// From now on: where `new` finds no memory, the process ends at once with one line and code 1. For programs whose work
/// is done in threads of libraries.
void end_where_memory_ends(const std::string& name);

/// A bar that fits into a line of the terminal. `left`: how long it takes still, in words. `columns`: 0 is not known.
std::string progress_line(const std::string& what, double fraction, const std::string& left, std::size_t columns);

/// Progress with time left. Thread-safe; draws at most ten times a second.
class Progress {
public:
    Progress(std::string what, double total, ProgressStyle style);
    ~Progress();
    void set(double done);
    /// A finished unit with a note ("frame 3"): always printed in json style.
    void step(double done, const std::string& note);

private:
    double seconds_left(double done) const;
    void draw(double done);
    void draw_if_due(double done);

    std::mutex mutex_;
    std::string what_;
    double total_;
    bool is_bar_, is_json_, is_drawn_ = false;
    Clock::time_point start_ = Clock::now();
    double last_drawn_s_ = 0;
};

}  // namespace equistream::cli
