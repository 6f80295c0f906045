/// Words of a command line and a settings file: whatever they are, a program does its work, or says why not in one line
/// and ends with 2. The input is words that a zero byte ends; what comes after an empty word is the file.
#include "target.h"

#include <equistream/error.h>
#include <programs/cli/program.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <optional>
#include <sstream>
#include <utility>

namespace equistream::fuzz {
namespace {

/// What is printed to `stream` meanwhile; sanitizers, which write to the descriptor, are not kept from it.
class Printed {
public:
    explicit Printed(FILE*& stream) : stream_(stream), before_(stream) { stream_ = open_memstream(&text_, &size_); }
    ~Printed() {
        std::fclose(std::exchange(stream_, before_));
        std::free(text_);
    }
    Printed(const Printed&) = delete;
    Printed& operator=(const Printed&) = delete;

    std::string text() const {
        std::fflush(stream_);
        return {text_, size_};
    }

private:
    FILE*& stream_;
    FILE* before_;
    char* text_ = nullptr;
    std::size_t size_ = 0;
};

/// Help goes to std::cout.
class Quiet {
public:
    ~Quiet() { std::cout.rdbuf(before_); }

private:
    std::ostringstream text_;
    std::streambuf* const before_ = std::cout.rdbuf(text_.rdbuf());
};

/// One of each kind that programs have.
struct Values {
    std::string size = "960x480", frames, progress = "auto", word = "off";
    std::optional<cli::FrameRange> range;
    std::uint64_t seed = 0;
    double share = 0;
    int count = 0;
    unsigned unsigned_count = 0;
    std::int64_t index = 0;
    std::optional<int> perhaps_count;
    std::optional<double> perhaps_share;
    std::filesystem::path file, folder;
    bool json = false, flag = false, other_flag = false;
    std::vector<std::string> words;
};

std::function<void()> added(cli::CommandLine& app, Values& values) {
    cli::add_with_default(app, "--size", values.size, "pixels");
    cli::add_frames_option(app, values.range, "frames");
    cli::add_seed_option(app, values.seed, "seed");
    cli::add_progress_option(app, values.progress);
    cli::add_json_flag(app, values.json);
    cli::add_with_default(app, "--denoise", values.word, "one of a few", {"off", "fast", "balanced"});
    app.add_option("--share", values.share, "of all").between(0.0, 1.0);
    app.add_option("--count", values.count, "how many").between(1, 64);
    app.add_option("--threads", values.unsigned_count, "how many").between(1u, 64u).group("Other");
    app.add_option("--first", values.index, "which").between(std::int64_t{0}, std::int64_t{9}).with_default("0");
    app.add_option("--perhaps", values.perhaps_count, "how many").type_name("N");
    app.add_option("--rate", values.perhaps_share, "how fast").expected(1);
    app.add_option("--file", values.file, "to read").existing_file();
    app.add_option("--folder", values.folder, "to read").existing_folder().description("a folder");
    const cli::Option flag = app.add_flag("--overwrite", values.flag, "replace");
    app.add_flag("--keep", values.other_flag, "do not").excludes(flag);
    app.footer("That is all.");
    const cli::CommandLine below = app.add_subcommand("below", "more words");
    cli::CommandLine(below).add_option("--share", values.share, "the same").between(0.0, 1.0);
    app.add_option("SOURCE", values.words, "files").one_word_each_time();
    return [&values, app, below, flag] {
        require(flag.is_given() == app.is_given("--overwrite") && !flag.name().empty() && !flag.group().empty(),
                "an option is told the same by both");
        require(!app.options().empty() && (!below.is_chosen() || app.is_chosen()), "who has a subcommand has words");
        const cli::Size size = cli::parse_size(values.size);
        require(size.width > 0 && size.height > 0, "a size has pixels");
        cli::parse_progress(values.progress);
        require(!values.range || (values.range->first >= 0 && values.range->first <= values.range->last),
                "frames go forward");
        require(values.share >= 0 && values.share <= 1, "a share is one");
        require(values.count == 0 || (values.count >= 1 && values.count <= 64), "a count is within its bounds");
    };
}

void read_command_line(Bytes bytes) {
    std::vector<std::string> words = {"equistream-render"};
    while (!bytes.empty() && words.size() < 100) {
        const auto end = std::ranges::find(bytes, 0);
        std::string word(bytes.begin(), end);
        bytes = bytes.subspan(std::min(bytes.size(), word.size() + 1));
        if (word.empty()) {
            words.push_back("--settings=" + scratch_file("settings.ini", bytes).string());
            break;
        }
        words.push_back(std::move(word));
    }
    std::vector<char*> arguments;
    for (std::string& word : words)
        arguments.push_back(word.data());
    require(cli::quoted_command(int(words.size()), arguments.data()).starts_with("equistream-render"),
            "a command is told by its name");
    arguments.push_back(nullptr);
    Values values;
    const Printed said(stderr), told(stdout);
    const Quiet help;
    const int code =
        cli::run_program(int(words.size()), arguments.data(), {"render", "Reads words", "equistream render"},
                         [&](cli::CommandLine& app) { return added(app, values); });
    std::string line = said.text();
    if (code == cli::exit_done) {
        require(line.empty(), "whoever is done has no errors to tell");
        return;
    }
    require(code == cli::exit_usage, "words cannot fail, they are wrong");
    require(!line.empty() && line.back() == '\n', "a line ends");
    line.pop_back();
    throw InputError(line);
}

constexpr std::array<std::string_view, 30> command_words = {
    "--size",     "--frames", "--seed",    "--json",     "--share",    "--count",  "--threads",   "--first",
    "--perhaps",  "--rate",   "--file",    "--folder",   "--keep",     "below",    "--overwrite", "--shar",
    "--sizes=1",  "--help",   "--version", "--progress", "[render]\n", "[play]\n", "[x]\n",       "[below]\n",
    "shar = 1\n", "64x0",     "3-2",       "--",         "\"a b\"",    "'it''s'"};

void damage_words(std::vector<std::uint8_t>& bytes, std::mt19937& random) {
    damage_text(command_words, bytes, random);
}

Seeds command_line_seeds() {
    using namespace std::string_literals;
    return {bytes_of("--size\0"s
                     "96x48\0"s
                     "--frames\0"s
                     "0-3\0"s
                     "--seed=7\0"s
                     "--json\0"s
                     "a.exr\0"s),
            bytes_of("--share\0"s
                     "0.5\0"s
                     "\0"s
                     "# how\nsize = 64x32\n[render]\ncount = 3\ndenoise = \"fast\"\n[encode]\ncrf = 20\n"s),
            bytes_of("--threads=3\0"s
                     "--first=3\0"s
                     "--perhaps=3\0"s
                     "--rate=0.5\0"s
                     "--folder=/\0"s
                     "it's\0"s
                     "below\0"s
                     "--share=0.25\0"s),
            bytes_of("--progress=none\0"s
                     "--denoise\0"s
                     "fast\0"s
                     "--overwrite\0"s
                     "--count\0"s
                     "64\0"s
                     "--\0"s
                     "-a\0"s)};
}

}  // namespace

const Target command_lines_target = {"command_lines", read_command_line, command_line_seeds, 600, damage_words};

}  // namespace equistream::fuzz
