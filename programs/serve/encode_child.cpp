#include "encode_child.h"

#include <equistream/error.h>
#include <programs/cli/child_failed.h>
#include <programs/cli/own_folder.h>
#include <programs/cli/program.h>

#include <asio/io_context.hpp>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <functional>
#include <optional>

extern char** environ;

namespace equistream::serve {

namespace {

pid_t spawn(const std::string& program, const std::string& name, const std::vector<std::string>& arguments) {
    std::vector<char*> argv{const_cast<char*>(name.c_str())};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);
    pid_t child = 0;
    const int failure = posix_spawn(&child, program.c_str(), &actions, nullptr, argv.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        throw WorkError(program + ": " + std::strerror(failure));
    return child;
}

}  // namespace

bool run_encode(asio::io_context& io, asio::signal_set& stop, const std::vector<std::string>& arguments) {
    asio::signal_set ended(io, SIGCHLD);
    const std::string program = (cli::own_folder() / "equistream-encode").string();
    const pid_t child = spawn(program, "equistream encode", arguments);
    bool stopped = false;
    std::optional<int> status;
    stop.async_wait([&](const asio::error_code& error, int) {
        if (error || status)  // the child has ended, and its number may be another's
            return;
        stopped = true;
        kill(child, SIGTERM);
    });
    std::function<void()> look = [&] {
        int found = 0;
        if (waitpid(child, &found, WNOHANG) == child) {
            status = found;
            stop.cancel();
            return;
        }
        ended.async_wait([&](const asio::error_code& error, int) {
            if (!error)
                look();
        });
    };
    look();
    io.run();
    io.restart();
    if (stopped)
        return false;
    if (!WIFEXITED(*status))
        throw WorkError(program + ": was ended by signal " + std::to_string(WTERMSIG(*status)));
    if (WEXITSTATUS(*status) != 0)
        throw cli::ChildFailed{WEXITSTATUS(*status)};
    return true;
}

}  // namespace equistream::serve
