#pragma once
/// What every program shares: exit codes, one-line errors, --settings, progress, common option values.
#include <CLI/CLI.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

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
                const std::function<std::function<void()>(CLI::App&)>& setup);

struct Size {
    int width = 0;
    int height = 0;
};
Size parse_size(const std::string& text);  ///< "960x480"

struct FrameRange {
    std::int64_t first = 0;
    std::int64_t last = 0;
};
FrameRange
parse_frames(const std::string& text);  ///< "0-149" or "7"; empty, negative or backward ranges are InputErrors

/// Adds --frames, which sets `frames` when it is given.
CLI::Option* add_frames_option(CLI::App& app, std::optional<FrameRange>& frames, const std::string& description);

/// Adds --seed: a whole number from 0 to 2^64 - 1, exactly; anything else is refused.
CLI::Option* add_seed_option(CLI::App& app, std::uint64_t& seed, const std::string& description);

/// The command line as one shell-quoted string, for manifests and reports; the program without its folder.
std::string quoted_command(int argc, char** argv);

enum class ProgressStyle { automatic, json, none };
/// Adds --json: the report on standard output is JSON and nothing else.
CLI::Option* add_json_flag(CLI::App& app, bool& json);

/// Adds --progress, whose value parse_progress() reads.
CLI::Option* add_progress_option(CLI::App& app, std::string& progress);

/// "auto" (a bar on a terminal, nothing elsewhere), "json" (a line per step on stderr), "none".
ProgressStyle parse_progress(const std::string& text);

/// Progress with time left. Thread-safe; draws at most ten times a second.
class Progress {
public:
    Progress(std::string what, double total, ProgressStyle style);
    ~Progress();
    void set(double done);
    /// A finished unit with a note ("frame 3"): always printed in json style.
    void step(double done, const std::string& note);

private:
    struct State;
    std::unique_ptr<State> state_;
};

// The file that --settings names.

/// Reads lines of option = value as CLI11 does. Lines in the section of a command, [play] say, are that command's
/// alone, so that one file serves several. A key that `app` has no option for is an InputError that names file, line
/// and the options there are.
class SettingsFile : public CLI::ConfigBase {
public:
    explicit SettingsFile(const CLI::App& app) : app_(app) {}
    std::vector<CLI::ConfigItem> from_config(std::istream& input) const override;

private:
    /// `place` is its name with its section's, as in the file's `text`.
    void require_known(const CLI::ConfigItem& item, const std::string& place, const std::string& text) const;

    const CLI::App& app_;  // it owns us
};

}  // namespace equistream::cli
