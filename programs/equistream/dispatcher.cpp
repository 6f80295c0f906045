/// `equistream COMMAND ...` runs the program equistream-COMMAND beside it, as git does: one program a process, so that
/// a renderer's libraries and the client's never meet.
#include <equistream/error.h>
#include <equistream/text.h>
#include <programs/cli/columns.h>
#include <programs/cli/commands.h>
#include <programs/cli/own_folder.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

namespace {

using equistream::cli::Command;
using equistream::cli::commands;
using equistream::cli::own_folder;

namespace fs = std::filesystem;

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;

void print_help(std::FILE* out) {
    const std::size_t columns = equistream::cli::output_columns();
    std::string text = "usage: equistream COMMAND [options]\n\n";
    for (const Command& command : commands) {
        std::string head = "  " + std::string(command.name);
        head.resize(12, ' ');
        text += equistream::cli::wrapped(head, command.summary, columns);
    }
    text += "\n" + equistream::cli::wrapped("",
                                            "'equistream help COMMAND' shows a command's manual, 'equistream COMMAND "
                                            "--help' its options and an example.\n'equistream doctor' says what is "
                                            "missing on this machine.",
                                            columns);
    std::fputs(text.c_str(), out);
}

const Command* find_command(std::string_view name) {
    const auto found = std::ranges::find(commands, name, &Command::name);
    return found == commands.end() ? nullptr : &*found;
}

void print_unknown(std::string_view word) {
    std::vector<std::string_view> names;
    for (const Command& command : commands)
        names.push_back(command.name);
    std::fprintf(stderr, "equistream: expected a command (%s), found '%.*s'%s\n",
                 equistream::in_a_sentence(names, ", ").c_str(), static_cast<int>(word.size()), word.data(),
                 equistream::cli::did_you_mean(word, names).c_str());
}

/// The value of `--host` among render's arguments, which decides what program runs; the program reads it too.
std::string host_of(const std::vector<std::string>& words) {
    for (std::size_t i = 1; i < words.size(); ++i) {
        if (words[i] == "--host" && i + 1 < words.size())
            return words[i + 1];
        if (words[i].starts_with("--host="))
            return words[i].substr(std::strlen("--host="));
    }
    return std::string(equistream::cli::hosts.front().name);
}

/// Becomes the command's program; `words` are the command and what it is given. Returns the exit status where it
/// cannot.
int start(const Command& command, const std::vector<std::string>& words) {
    fs::path program = own_folder() / command.program;
    try {
        if (command.name == "render")
            program = equistream::cli::host_program(host_of(words), own_folder());
    } catch (const equistream::InputError& problem) {
        std::fprintf(stderr, "equistream render: %s\n", problem.what());
        return exit_usage;
    }
    // What was typed, for the records that programs keep of their command.
    const std::string typed = "equistream " + words[0];
    std::vector<char*> arguments{const_cast<char*>(typed.c_str())};
    for (std::size_t i = 1; i < words.size(); ++i)
        arguments.push_back(const_cast<char*>(words[i].c_str()));
    arguments.push_back(nullptr);
    execv(program.c_str(), arguments.data());
    std::fprintf(stderr, "equistream: %s: %s\n", program.c_str(), std::strerror(errno));
    return exit_failed;
}

/// Becomes man with this page of ours; returns where there is no page or no man.
void show_manual(const std::string& page) {
    const fs::path folder = own_folder().parent_path() / "share/man/man1";
    for (const char* ending : {".1", ".1.gz"}) {
        const fs::path file = folder / (page + ending);
        std::error_code error;
        if (fs::exists(file, error))
            execlp("man", "man", file.c_str(), nullptr);
    }
}

/// `words`: what stands after help, a command and perhaps a subcommand or options that choose another help.
int help(std::vector<std::string> words) {
    const bool is_read = isatty(STDOUT_FILENO) == 1;  // a pager waits for keys
    if (words.empty()) {
        if (is_read)
            show_manual("equistream");
        print_help(stdout);
        return 0;
    }
    const Command* command = find_command(words[0]);
    if (command == nullptr) {
        print_unknown(words[0]);
        return exit_usage;
    }
    if (is_read && words.size() == 1)
        show_manual("equistream-" + words[0]);
    words.emplace_back("--help");
    return start(*command, words);
}

int run(int argc, char** argv) {
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    if (words.empty()) {
        print_help(stderr);
        return exit_usage;
    }
    const std::string& name = words[0];
    if (name == "--help" || name == "-h") {
        print_help(stdout);
        return 0;
    }
    if (name == "help")
        return help({words.begin() + 1, words.end()});
    if (name == "--version") {
        std::puts("equistream " EQUISTREAM_VERSION);
        return 0;
    }
    if (const Command* command = find_command(name))
        return start(*command, words);
    print_unknown(name);
    return exit_usage;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& problem) {
        std::fprintf(stderr, "equistream: %s\n", problem.what());
        return exit_failed;
    }
}
