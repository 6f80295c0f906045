/// `equistream COMMAND ...` runs the program equistream-COMMAND beside it, as git does: one program a process, so that
/// a renderer's libraries and the client's never meet.
#include <equistream/error.h>
#include <equistream/text.h>
#include <programs/cli/commands.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

namespace {

using equistream::cli::Command;
using equistream::cli::commands;

constexpr int exit_failed = 1;
constexpr int exit_usage = 2;

void print_help(std::FILE* out) {
    std::fputs("usage: equistream COMMAND [options]\n\n", out);
    for (const Command& command : commands)
        std::fprintf(out, "  %-10s%s\n", command.name.data(), command.summary.data());
    std::fputs("\n'equistream COMMAND --help' shows a command's options and an example.\n", out);
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
std::string host_of(const std::vector<char*>& arguments) {
    for (std::size_t i = 2; i < arguments.size(); ++i) {
        const std::string_view word = arguments[i];
        if (word == "--host" && i + 1 < arguments.size())
            return arguments[i + 1];
        if (word.starts_with("--host="))
            return std::string(word.substr(std::strlen("--host=")));
    }
    return std::string(equistream::cli::hosts.front().name);
}

}  // namespace

int main(int argc, char** argv) {
    const std::string_view name = argc > 1 ? argv[1] : "";
    if (name == "--help" || name == "-h" || name == "help") {
        print_help(stdout);
        return 0;
    }
    if (name == "--version") {
        std::puts("equistream " EQUISTREAM_VERSION);
        return 0;
    }
    for (const Command& command : commands) {
        if (command.name != name)
            continue;
        std::vector<char*> arguments(argv, argv + argc);
        std::error_code error;
        const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
        std::filesystem::path program = folder / command.program;
        try {
            if (name == "render")
                program = equistream::cli::host_program(host_of(arguments), folder);
        } catch (const equistream::InputError& problem) {
            std::fprintf(stderr, "equistream render: %s\n", problem.what());
            return exit_usage;
        }
        // What was typed, for the records that programs keep of their command.
        std::string typed = "equistream " + std::string(name);
        arguments.erase(arguments.begin());
        arguments[0] = typed.data();
        arguments.push_back(nullptr);
        execv(program.c_str(), arguments.data());
        std::fprintf(stderr, "equistream: %s: %s\n", program.c_str(), std::strerror(errno));
        return exit_failed;
    }
    if (name.empty())
        print_help(stderr);
    else
        print_unknown(name);
    return exit_usage;
}
