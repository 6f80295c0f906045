#include <equistream/error.h>
#include <programs/cli/columns.h>
#include <programs/cli/commands.h>
#include <programs/cli/program.h>
#include <programs/cli/provenance.h>
#include <programs/cli/settings_text.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace equistream::cli {
namespace {

TEST(Size, ReadsWidthAndHeight) {
    const Size size = parse_size("960x480");
    EXPECT_EQ(size.width, 960);
    EXPECT_EQ(size.height, 480);
}

TEST(Size, RefusesWhatIsNoSize) {
    for (const char* bad : {"", "960", "x480", "960x", "0x480", "-1x2", "960x480x2", "99999x2", "9e2x480", "960 x480"})
        EXPECT_THROW(parse_size(bad), InputError) << bad;
}

TEST(Frames, ReadsRangesAndSingles) {
    EXPECT_EQ(parse_frames("0-149").last, 149);
    EXPECT_EQ(parse_frames("7").first, 7);
    EXPECT_EQ(parse_frames("7").last, 7);
}

TEST(Frames, RefusesEmptyBackwardAndNegativeRanges) {
    for (const char* bad : {"", "5-4", "-3", "-3-4", "3-", "a-b", "1-2-3", "0-99999999999"})
        EXPECT_THROW(parse_frames(bad), InputError) << bad;
}

/// Runs a program and returns its exit code; what it says on standard error goes to `errors`.
int run(std::vector<std::string> words, std::string& errors,
        const std::function<std::function<void()>(CommandLine&)>& setup) {
    std::vector<char*> argv;
    for (auto& word : words)
        argv.push_back(word.data());
    testing::internal::CaptureStderr();
    const int code =
        run_program(static_cast<int>(argv.size()), argv.data(), {"test", "A test.", "equistream test"}, setup);
    errors = testing::internal::GetCapturedStderr();
    return code;
}

/// One with the option --n.
int run(
    std::vector<std::string> words, int& n, std::string& errors, const std::function<void()>& body = [] {}) {
    return run(std::move(words), errors, [&](CommandLine& app) {
        app.add_option("--n", n, "A number");
        return body;
    });
}

TEST(Seed, IsTakenExactlyOrRefused) {
    std::string errors;
    const auto parse = [&](std::vector<std::string> words) {
        std::uint64_t seed = 1;
        words.insert(words.begin(), "p");
        const int code = run(std::move(words), errors, [&](CommandLine& app) -> std::function<void()> {
            add_seed_option(app, seed, "A seed");
            return [] {};
        });
        return code == exit_done ? std::optional(seed) : std::nullopt;
    };
    EXPECT_EQ(parse({}), 1u);
    EXPECT_EQ(parse({"--seed", "18446744073709551615"}), std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(parse({"--seed", "0"}), 0u);
    for (const char* bad : {"18446744073709551616", "99999999999999999999", "-1", "1e3", "0x10", " 1", "", "1.5"}) {
        EXPECT_EQ(parse({"--seed", bad}), std::nullopt) << bad;
        EXPECT_NE(errors.find("--seed"), std::string::npos) << errors;
    }
}

TEST(Option, OfANumberRefusesAnEmptyWordAndNaN) {
    std::optional<double> value;
    std::string errors;
    const auto parse = [&](const std::string& word) {
        return run({"p", "--x", word}, errors, [&](CommandLine& app) -> std::function<void()> {
            app.add_option("--x", value, "A number");
            return [] {};
        });
    };
    EXPECT_EQ(parse(""), exit_usage);
    EXPECT_EQ(errors, "equistream test: --x: expected a number, found '' (--help lists the options)\n");
    EXPECT_EQ(parse("nan"), exit_usage) << "CLI11 finds it in every range";
    EXPECT_EQ(errors, "equistream test: --x: expected a number, found 'nan' (--help lists the options)\n");
    int n = 3;
    EXPECT_EQ(run({"p", "--n", ""}, n, errors), exit_usage);
    EXPECT_EQ(n, 3);
    EXPECT_EQ(parse("2.5"), exit_done) << errors;
    EXPECT_EQ(value, 2.5);
}

TEST(Progress, RefusesUnknownStyles) {
    EXPECT_THROW(parse_progress("loud"), InputError);
}

TEST(Progress, FitsIntoALineOfTheTerminal) {
    for (const std::size_t columns : {1u, 10u, 20u, 40u, 56u, 80u})
        for (const char* left : {"", "0:07 left", "12:34:56 left"})
            EXPECT_LT(progress_line("render", 0.5, left, columns).size(), columns);
    const std::string whole = "render [###############...............]  50% 0:07 left     ";
    EXPECT_EQ(progress_line("render", 0.5, "0:07 left", 80), whole);
    EXPECT_EQ(progress_line("render", 0.5, "0:07 left", 0), whole);
    EXPECT_EQ(progress_line("render", 0.5, "0:07 left", 40), "render [#####.....]  50% 0:07 left     ");
    EXPECT_EQ(progress_line("render", 0.5, "0:07 left", 28), "render  50% 0:07 left     ");
}

TEST(DidYouMean, NamesWhatIsNear) {
    const std::vector<std::string> options = {"--frames", "--fps", "--size", "--spp", "--patch-side"};
    EXPECT_EQ(nearest_word("--frame", options), "--frames");
    EXPECT_EQ(nearest_word("--sise", options), "--size");
    EXPECT_EQ(nearest_word("--psp", options), "--spp") << "two letters swapped are one mistake";
    EXPECT_EQ(nearest_word("--patch", options), "--patch-side");
    EXPECT_EQ(nearest_word("--nothing-like-it", options), "");
    EXPECT_EQ(nearest_word("rendr", std::vector<std::string>{"encode", "render", "serve"}), "render");
    EXPECT_EQ(did_you_mean("paint", std::vector<std::string>{"encode", "render", "serve"}), "");
}

TEST(Provenance, NamesCommandVersionAndMachine) {
    const nlohmann::ordered_json made = provenance("equistream test --n 1");
    EXPECT_EQ(made["command"], "equistream test --n 1");
    EXPECT_FALSE(made["version"].get<std::string>().empty());
    EXPECT_FALSE(made["machine"]["cpu"].get<std::string>().empty());
    EXPECT_GE(made["machine"]["threads"], 1);
}

TEST(Host, OfALibraryThatNeedsAvx2IsRefusedWithoutIt) {
    const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "hosts";
    std::filesystem::create_directories(folder);
    for (const Host& host : hosts)
        std::ofstream(folder / host.program) << "a program";
    EXPECT_EQ(host_program("mitsuba", folder, true), folder / "equistream-render-mitsuba");
    EXPECT_EQ(host_program("embree", folder, false), folder / "equistream-render-embree");
    try {
        host_program("mitsuba", folder, false);
        ADD_FAILURE() << "it would end by SIGILL";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).find("--host mitsuba: expected a processor with AVX2, found one without"),
                  0u)
            << error.what();
    }
}

TEST(Command, IsQuotedForTheShell) {
    std::vector<std::string> words = {"equistream", "a b", "it's", "--x=1"};
    std::vector<char*> argv;
    for (auto& word : words)
        argv.push_back(word.data());
    EXPECT_EQ(quoted_command(4, argv.data()), "equistream 'a b' 'it'\\''s' --x=1");
}

TEST(Program, MapsErrorsToExitCodesAndOneLine) {
    int n = 0;
    std::string errors;
    EXPECT_EQ(run({"p", "--n", "3"}, n, errors), exit_done);
    EXPECT_EQ(n, 3);
    EXPECT_EQ(errors, "");
    EXPECT_EQ(run({"p", "--n", "x"}, n, errors), exit_usage);
    EXPECT_EQ(std::count(errors.begin(), errors.end(), '\n'), 1) << errors;
    EXPECT_EQ(run({"p", "--unknown"}, n, errors), exit_usage);
    EXPECT_NE(errors.find("--unknown"), std::string::npos) << errors;
    EXPECT_EQ(run({"p"}, n, errors, [] { throw InputError("scene.json:3: expected a,\nfound b\n"); }), exit_usage);
    EXPECT_EQ(errors, "equistream test: scene.json:3: expected a, found b\n");
    EXPECT_EQ(run({"p"}, n, errors, [] { throw WorkError("disk full"); }), exit_failed);
}

TEST(Program, ReadsSettingsAndRefusesUnknownKeys) {
    const std::string file = testing::TempDir() + "settings.ini";
    int n = 0;
    std::string errors;
    std::ofstream(file) << "n = 5\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_done) << errors;
    EXPECT_EQ(n, 5);
    EXPECT_EQ(run({"p", "--settings", file, "--n", "6"}, n, errors), exit_done) << errors;
    EXPECT_EQ(n, 6);
    std::ofstream(file) << "# mine\nn = 4\nm = 5\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_usage);
    EXPECT_EQ(errors, "equistream test: " + file + ":3: expected one of n, found 'm'\n");
    std::ofstream(file) << "n = 4\n[other]\nn = 5\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_usage);
    EXPECT_EQ(errors, "equistream test: " + file + ":2: expected a command's name in brackets, found '[other]'\n");
    std::ofstream(file) << "n = 4\n[play]\nm = 5\nmethod = mesh\n[test]\nn = 7\n[encode]\ncrf = 20\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_done)
        << "other commands' sections are theirs: " << errors;
    EXPECT_EQ(n, 7);
    std::ofstream(file) << "[play]\nm = 5\n[test]\nn = 7\nm = 5\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_usage);
    EXPECT_EQ(errors, "equistream test: " + file + ":5: expected one of n, found 'test.m'\n");
    std::ofstream(file) << "help = true\n";
    EXPECT_EQ(run({"p", "--settings", file}, n, errors), exit_usage);
    EXPECT_EQ(errors, "equistream test: " + file + ":1: expected one of n, found 'help'\n");
    EXPECT_EQ(run({"p", "--settings", file + ".missing"}, n, errors), exit_usage);
}

TEST(Program, SaysWhereASettingWasRead) {
    const std::string file = testing::TempDir() + "places.ini";
    int n = 0;
    std::string errors;
    const auto told = [&](const std::string& text, std::vector<std::string> words, const std::string& problem = "") {
        std::ofstream(file) << text;
        words.insert(words.begin(), {"p", "--settings", file});
        EXPECT_EQ(run(words, n, errors, [&] { throw InputError(problem); }), exit_usage);
        return errors;
    };
    const std::string place = "equistream test: " + file;
    const std::string help = " (--help lists the options)\n";
    EXPECT_EQ(told("# mine\nn = zwei\n", {}), place + ":2: --n: expected a whole number, found 'zwei'" + help);
    EXPECT_EQ(told("[test]\nn = zwei\n", {}), place + ":2: --n: expected a whole number, found 'zwei'" + help);
    EXPECT_EQ(told("n = 1\n\nn = 2\n", {}), place + ":3: expected n once, found it again, after line 1\n");
    EXPECT_EQ(told("n = [1, 2]\n", {}), place + ":1: expected one value of n, found 2\n");
    EXPECT_EQ(told("[rendr]\nn = 1\n", {}),
              place + ":1: expected a command's name in brackets, found '[rendr]'; did you mean render?\n");
    EXPECT_EQ(told("\nn = 3\n", {}, "--n 3: expected 4"), place + ":2: --n 3: expected 4\n");
    EXPECT_EQ(told("\nn = 3\n", {"--n", "5"}, "--n 5: expected 4"), "equistream test: --n 5: expected 4\n");
    EXPECT_EQ(run({"p", "--settings", testing::TempDir()}, n, errors), exit_usage);
    EXPECT_EQ(errors, "equistream test: --settings " + testing::TempDir() +
                          ": expected a file of settings, found a folder" + help);
}

/// Lines of one option need not follow each other. Those of the command's own section take the place of the others.
TEST(Program, AnOptionThatMayBeRepeatedKeepsAllItsLines) {
    const std::string file = testing::TempDir() + "repeated.ini";
    const auto values_of = [&](const std::string& text) {
        std::ofstream(file) << text;
        std::vector<std::string> values;
        bool other = false;
        std::string errors;
        EXPECT_EQ(run({"p", "--settings", file}, errors,
                      [&](CommandLine& app) -> std::function<void()> {
                          app.add_option("--value", values, "");
                          app.add_flag("--other", other, "");
                          return [] {};
                      }),
                  exit_done)
            << errors;
        return values;
    };
    using Values = std::vector<std::string>;
    EXPECT_EQ(values_of("value = a\nother = true\nvalue = b\n"), (Values{"a", "b"}));
    EXPECT_EQ(values_of("[test]\nvalue = a\nother = true\nvalue = b\n"), (Values{"a", "b"}));
    EXPECT_EQ(values_of("value = a\n[test]\nvalue = b\nother = true\nvalue = c\n"), (Values{"b", "c"}));
    EXPECT_EQ(values_of("[test]\nvalue = b\n[play]\n[test]\nother = true\n"), (Values{"b"}));
}

/// Of a command with subcommands; other commands leave them alone.
TEST(Program, SectionsOfSubcommandsAreNamedWithTheirCommand) {
    const std::string file = testing::TempDir() + "subcommands.ini";
    int value = 0;
    std::string errors;
    const auto status_of = [&](const std::string& text) {
        value = 0;
        std::ofstream(file) << text;
        return run({"p", "--settings", file, "info"}, errors, [&](CommandLine& app) -> std::function<void()> {
            app.add_subcommand("info", "").add_option("--value", value, "");
            return [] {};
        });
    };
    EXPECT_EQ(status_of("[test.info]\nvalue = 3\n"), exit_done) << errors;
    EXPECT_EQ(value, 3);
    EXPECT_EQ(status_of("[info]\nvalue = 3\nother = 5\n[scene.info]\nvalue = 4\n"), exit_done)
        << "other commands' sections: " << errors;
    EXPECT_EQ(value, 0);
    EXPECT_EQ(status_of("value = 3\n"), exit_usage);
    EXPECT_NE(errors.find("expected options of [test.info], found 'value'"), std::string::npos) << errors;
}

TEST(Program, AnOptionReplacesInTheFileWhatItExcludes) {
    const std::string file = testing::TempDir() + "excluded.ini";
    std::string scene, model, errors;
    const auto run_with = [&](const std::string& text, std::vector<std::string> words) {
        scene = model = "";
        std::ofstream(file) << text;
        words.insert(words.begin(), {"p", "--settings", file});
        return run(words, errors, [&](CommandLine& app) -> std::function<void()> {
            const Option other = app.add_option("--scene", scene, "");
            app.add_option("--model", model, "").excludes(other);
            return [] {};
        });
    };
    EXPECT_EQ(run_with("model = m\n", {"--scene", "s"}), exit_done) << errors;
    EXPECT_EQ(scene + "," + model, "s,");
    EXPECT_EQ(run_with("[test]\nscene = s\n", {"--model", "m"}), exit_done) << errors;
    EXPECT_EQ(scene + "," + model, ",m");
    EXPECT_EQ(run_with("model = m\nscene = s\n", {"--scene", "t"}), exit_done) << errors;
    EXPECT_EQ(scene + "," + model, "t,");
    EXPECT_EQ(run_with("model = m\n", {}), exit_done) << errors;
    EXPECT_EQ(scene + "," + model, ",m");
    EXPECT_EQ(run_with("model = m\nscene = s\n", {}), exit_usage);
    EXPECT_EQ(run_with("", {"--scene", "s", "--model", "m"}), exit_usage);
}

TEST(Program, RefusesInItsOwnWords) {
    std::string out, word, errors;
    double crf = 0;
    bool flag = false;
    const auto told = [&](std::vector<std::string> words) {
        words.insert(words.begin(), "p");
        EXPECT_EQ(run(words, errors,
                      [&](CommandLine& app) -> std::function<void()> {
                          app.add_option("--out", out, "").required();
                          app.add_option("--word", word, "").one_of({"on", "off"});
                          app.add_option("--crf", crf, "").between(0.0, 51.0);
                          app.add_flag("--flag", flag, "");
                          return [] {};
                      }),
                  exit_usage);
        const std::string begin = "equistream test: ", end = " (--help lists the options)\n";
        EXPECT_TRUE(errors.starts_with(begin) && errors.ends_with(end)) << errors;
        return errors.substr(begin.size(), errors.size() - std::min(errors.size(), begin.size() + end.size()));
    };
    EXPECT_EQ(told({"-o", "a"}), "-o: no such option; did you mean --out?");
    EXPECT_EQ(told({"--out"}), "--out: expected one value, found none");
    EXPECT_EQ(told({"--out", "a", "--out", "b"}), "--out: expected one value, found 2");
    EXPECT_EQ(told({"--out", "a", "b"}), "expected no further words, found 'b'");
    EXPECT_EQ(told({"--out", "a", "--word", "x"}), "--word: expected on or off, found 'x'");
    EXPECT_EQ(told({"--out", "a", "--crf", "abc"}), "--crf: expected a number from 0 to 51, found 'abc'");
    EXPECT_EQ(told({"--out", "a", "--crf", "52"}), "--crf: expected a number from 0 to 51, found '52'");
    EXPECT_EQ(told({"--out", "a", "--flag=perhaps"}), "--flag: expected true or false, found 'perhaps'");
}

TEST(Program, NamesItsSubcommands) {
    std::string errors;
    const auto told = [&](std::vector<std::string> words) {
        EXPECT_EQ(run(std::move(words), errors,
                      [](CommandLine& app) -> std::function<void()> {
                          app.add_subcommand("generate", "");
                          app.add_subcommand("info", "");
                          app.require_subcommand();
                          return [] {};
                      }),
                  exit_usage);
        return errors;
    };
    const std::string begin = "equistream test: expected generate or info, found ",
                      end = " (--help lists the options)\n";
    EXPECT_EQ(told({"p", "inf", "a.json"}), begin + "'inf'; did you mean info?" + end);
    EXPECT_EQ(told({"p"}), begin + "none" + end);
}

TEST(Wrapped, LinesFitAndBeginBelowEachOther) {
    EXPECT_EQ(wrapped("  --x  ", "one two three", 14), "  --x  one two\n       three\n");
    EXPECT_EQ(wrapped("", "one two", 7), "one two\n");
    EXPECT_EQ(wrapped("", "abcdefghij kl", 5), "abcdefghij\nkl\n");
    EXPECT_EQ(wrapped("- ", "a\nb", 40), "- a\n  b\n");
    EXPECT_EQ(wrapped("", "rate=N    so many a second", 20), "rate=N    so many a\n          second\n");
    EXPECT_EQ(wrapped("  --x", "", 40), "  --x\n");
}

TEST(Help, FitsTheTerminal) {
    const std::string meaning = "How well the picture looks: the lower, the better, and the more bytes it takes";
    setenv("COLUMNS", "60", 1);
    std::string errors, text;
    double crf = 16;
    testing::internal::CaptureStdout();
    EXPECT_EQ(run({"p", "--help"}, errors,
                  [&](CommandLine& app) -> std::function<void()> {
                      app.add_option("--crf", crf, meaning);
                      return [] {};
                  }),
              exit_done);
    std::istringstream lines(testing::internal::GetCapturedStdout());
    unsetenv("COLUMNS");
    std::string found;
    std::size_t column = 0;
    for (std::string line; std::getline(lines, line);) {
        EXPECT_LE(line.size(), 60u) << line;
        if (line.starts_with("  --crf"))
            column = line.find("How");
        else if (column > 0 && line.find_first_not_of(' ') != column)
            break;
        if (column > 0)
            found += (found.empty() ? "" : " ") + line.substr(column);
    }
    EXPECT_GT(column, 8u);
    EXPECT_EQ(found, meaning);
}

TEST(SettingsText, IsMadeOneThatIsReadAsItIsMeant) {
    const auto read = [](const std::string& text) { return settings_for_reader(text, "a.ini"); };
    EXPECT_EQ(read("\xef\xbb\xbfsize = 64x64 # note\r\n  fov=80\n# all of it\n\n[play] # mine\nflag # on\n"),
              "size = 64x64\nfov= 80\n\n\n[play]\nflag\n");
    EXPECT_EQ(read("out = \"take #2/eyes\" # where\nout = 'take #2'\n"), "out = \"take #2/eyes\"\nout = 'take #2'\n");
    EXPECT_EQ(read("out = play#1\nout = views,#2\nout = rock ; roll\n"),
              "out = \"play#1\"\nout = \"views,#2\"\nout = \"rock ; roll\"\n");
    EXPECT_EQ(read("fill = hidden,base\nout = with space.mkv\nout = say \"so\"\nout = it's\n"),
              "fill = \"hidden,base\"\nout = \"with space.mkv\"\nout = 'say \"so\"'\nout = it's\n");
    EXPECT_EQ(read("list = [1, 2]\nlist = [\"a=1\",\n\"b=2\"]\nempty =\n"),
              "list = [1, 2]\nlist = [\"a=1\",\"b=2\"]\n\nempty = \n");
    EXPECT_EQ(read("list = [a, b] # x\nn = 1\n"), "list = [a, b]\nn = 1\n");
    EXPECT_EQ(read("list = [\n\"a # ]\", # x\nit's # y\n]\nn = 1\n"), "list = [\"a # ]\",it's]\n\n\n\nn = 1\n");
    for (const std::string value : {"\"open", "it's \"so\"", "\"a\", \"b\"", "[\"a, b]", "['tis]", "[a] b", "[a"}) {
        try {
            read("a = 1\nout = " + value + "\n");
            ADD_FAILURE() << value;
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).find("a.ini:2: expected "), 0u) << error.what();
        }
    }
}

/// What the reader behind it makes of such values.
TEST(SettingsText, ValuesAreWhatTheyLookLike) {
    for (const auto& [line, expected] : {std::pair<std::string, std::string>{"views,#2", "views,#2"},
                                         {"take #2 # a remark", "take"},
                                         {"\"take #2, again\"", "take #2, again"},
                                         {"say \"so\"", "say \"so\""},
                                         {"it's", "it's"},
                                         {"a b,c", "a b,c"}}) {
        const std::string file = testing::TempDir() + "values.ini";
        std::ofstream(file) << "text = " << line << "\n";
        std::string found;
        const std::vector<std::string> words = {"p", "--settings", file};
        std::vector<char*> argv;
        for (const std::string& word : words)
            argv.push_back(const_cast<char*>(word.c_str()));
        const int status = run_program(int(argv.size()), argv.data(), {"test", "", ""}, [&](CommandLine& app) {
            app.add_option("--text", found, "");
            return [] {};
        });
        EXPECT_EQ(status, exit_done) << line;
        EXPECT_EQ(found, expected) << line;
    }
}

TEST(Program, AFileBeyondTheLimitOfSizesIsAnErrorAndNotTheEnd) {
    const auto before = std::signal(SIGXFSZ, SIG_DFL);
    int n = 0;
    std::string errors;
    EXPECT_EQ(run({"p"}, n, errors), exit_done);
    EXPECT_EQ(std::signal(SIGXFSZ, before), SIG_IGN);
}

}  // namespace
}  // namespace equistream::cli
