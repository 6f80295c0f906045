#include "program.h"
#include "child_failed.h"
#include "did_you_mean.h"
#include "settings_file.h"

#include <equistream/error.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

namespace equistream::cli {

namespace {

/// Errors are one line, whatever a library put into its message.
std::string one_line(std::string text) {
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    for (char& c : text)
        if (c == '\n')
            c = ' ';
    return text;
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

}  // namespace

int run_program(int argc, char** argv, const ProgramText& text,
                const std::function<std::function<void()>(CLI::App&)>& setup) {
    const std::string& name = text.name;
    std::signal(SIGXFSZ, SIG_IGN);  // write() then says why
    CLI::App app(text.summary, "equistream " + name);
    app.set_version_flag("--version", std::string("equistream ") + EQUISTREAM_VERSION);
    app.set_config("--settings", "", "Read options from a file: lines of option = value (command line wins)")
        ->type_name("FILE");
    app.config_formatter(std::make_shared<SettingsFile>(app));
    app.allow_config_extras(CLI::config_extras_mode::error);
    app.footer("Example:\n  " + text.example + "\n\nExit status: 0 done, 1 failed, 2 bad usage or input.");
    app.get_formatter()->column_width(34);
    try {
        const auto run = setup(app);
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

}  // namespace equistream::cli
