#include "program.h"

#include <equistream/error.h>
#include <equistream/image.h>

#include <charconv>
#include <limits>

namespace equistream::cli {

namespace {

/// The whole of `text` as a number, digits only.
template <typename Integer>
bool read_whole(std::string_view text, Integer& value) {
    const char* end = text.data() + text.size();
    const auto result = std::from_chars(text.data(), end, value);
    return !text.empty() && result.ec == std::errc() && result.ptr == end;
}

std::string in_quotes(std::string_view text) {
    return "'" + std::string(text) + "'";
}

}  // namespace

Size parse_size(const std::string& text) {
    const std::size_t x = text.find('x');
    Size size;
    const bool good = x != std::string::npos && read_whole(std::string_view(text).substr(0, x), size.width) &&
                      read_whole(std::string_view(text).substr(x + 1), size.height);
    if (!good || size.width < 1 || size.height < 1 || size.width > max_image_side || size.height > max_image_side)
        throw InputError(expected_found("--size", "WxH, each 1 to " + std::to_string(max_image_side), in_quotes(text)));
    return size;
}

FrameRange parse_frames(const std::string& text) {
    const std::size_t dash = text.find('-', 1);
    FrameRange range;
    bool good = read_whole(std::string_view(text).substr(0, dash), range.first);
    range.last = range.first;
    if (dash != std::string::npos)
        good = good && read_whole(std::string_view(text).substr(dash + 1), range.last);
    if (!good || range.first < 0)
        throw InputError(expected_found("--frames", "FIRST-LAST or one frame number, from 0", in_quotes(text)));
    if (range.last < range.first)
        throw InputError(expected_found("--frames", "the last frame not before the first", in_quotes(text)));
    if (range.last >= std::numeric_limits<std::int32_t>::max())
        throw InputError(expected_found("--frames", "frame numbers below 2147483647", in_quotes(text)));
    return range;
}

CLI::Option* add_frames_option(CLI::App& app, std::optional<FrameRange>& frames, const std::string& description) {
    return app.add_option_function<std::string>(
        "--frames", [&frames](const std::string& text) { frames = parse_frames(text); }, description);
}

CLI::Option* add_seed_option(CLI::App& app, std::uint64_t& seed, const std::string& description) {
    return app
        .add_option_function<std::string>(
            "--seed",
            [&seed](const std::string& text) {
                if (!read_whole(text, seed))
                    throw InputError(
                        expected_found("--seed", "a whole number from 0 to 18446744073709551615", in_quotes(text)));
            },
            description)
        ->type_name("UINT")
        ->default_str(std::to_string(seed));
}

CLI::Option* add_json_flag(CLI::App& app, bool& json) {
    return app.add_flag("--json", json, "Report as JSON on standard output");
}

CLI::Option* add_progress_option(CLI::App& app, std::string& progress) {
    return app
        .add_option("--progress", progress,
                    "auto: a bar on a terminal; json: a line of JSON a step on standard error; none: nothing")
        ->capture_default_str();
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
