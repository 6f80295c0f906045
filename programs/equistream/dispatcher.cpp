/// `equistream COMMAND ...` runs the program equistream-COMMAND beside it, as git does: one program a process, so that
/// a renderer's libraries and the client's never meet.
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
using equistream::cli::Host;

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
std::string_view host_of(const std::vector<char*>& arguments) {
    for (std::size_t i = 2; i < arguments.size(); ++i) {
        const std::string_view word = arguments[i];
        if (word == "--host" && i + 1 < arguments.size())
            return arguments[i + 1];
        if (word.starts_with("--host="))
            return word.substr(std::strlen("--host="));
    }
    return equistream::cli::hosts.front().name;
}

/// Null, and said why, for a host that this build does not have.
const Host* host_there(std::string_view name, const std::filesystem::path& folder) {
    const Host* host = equistream::cli::find_host(name);
    std::error_code error;
    if (host == nullptr)
        std::fprintf(stderr, "equistream render: --host: expected %s, found '%.*s'\n",
                     equistream::cli::host_names().c_str(), static_cast<int>(name.size()), name.data());
    else if (!std::filesystem::exists(folder / host->program, error))
        std::fprintf(stderr, "equistream render: --host %s: expected %s, found none; to get it: %s\n",
                     host->name.data(), (folder / host->program).c_str(), host->how_to_get_it.data());
    else
        return host;
    return nullptr;
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
        std::string_view beside = command.program;
        if (name == "render") {
            const Host* host = host_there(host_of(arguments), folder);
            if (host == nullptr)
                return exit_usage;
            beside = host->program;
        }
        const std::string program = (folder / beside).string();
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
