#include "child_process.h"

#include <equistream/error.h>
#include <programs/cli/process.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace equistream::mitsuba_host {
namespace {

struct Pipe {
    int read_end = -1, write_end = -1;
    Pipe() {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0)
            throw WorkError(std::string("a pipe could not be made: ") + std::strerror(errno));
        read_end = ends[0];
        write_end = ends[1];
    }
    ~Pipe() {
        close(read_end);
        close_write_end();
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;
    void close_write_end() {
        if (write_end >= 0)
            close(write_end);
        write_end = -1;
    }
};

/// Reads both until they are closed, so that neither can fill up and block the writer.
void drain(const std::array<int, 2>& ends, const std::array<std::string*, 2>& texts) {
    std::array<pollfd, 2> waiting{pollfd{ends[0], POLLIN, 0}, pollfd{ends[1], POLLIN, 0}};
    int open = 2;
    while (open > 0) {
        if (poll(waiting.data(), waiting.size(), -1) < 0 && errno != EINTR)
            break;
        for (std::size_t i = 0; i < waiting.size(); ++i) {
            if (waiting[i].fd < 0 || waiting[i].revents == 0)
                continue;
            char block[65536];
            const ssize_t count = read(waiting[i].fd, block, sizeof block);
            if (count > 0)
                texts[i]->append(block, static_cast<std::size_t>(count));
            else if (count == 0 || errno != EINTR) {
                waiting[i].fd = -1;
                --open;
            }
        }
    }
}

/// "equistream scene: FILE: expected ..." without what names the program.
std::string complaint(std::string text) {
    while (!text.empty() && text.back() == '\n')
        text.pop_back();
    text = text.substr(text.rfind('\n') == std::string::npos ? 0 : text.rfind('\n') + 1);
    const std::string prefix = "equistream scene: ";
    return text.starts_with(prefix) ? text.substr(prefix.size()) : text;
}

/// Exit status of a child whose program could not be started, and wrote errno to standard error; shells use it too.
constexpr int not_started = 127;

}  // namespace

std::string run_beside(const std::string& program, const std::vector<std::string>& arguments) {
    const std::string file = (cli::own_folder() / program).string();
    std::vector<char*> argv{const_cast<char*>(file.c_str())};
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);
    Pipe out, err;
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0) {
        // Or it would go on and hold its folder, were this program killed.
        if (prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && getppid() == parent && dup2(out.write_end, STDOUT_FILENO) >= 0 &&
            dup2(err.write_end, STDERR_FILENO) >= 0)
            execv(file.c_str(), argv.data());
        const int reason = errno;
        _exit(write(err.write_end, &reason, sizeof reason) == sizeof reason ? not_started : EXIT_FAILURE);
    }
    if (child < 0)
        throw WorkError(file + ": " + std::strerror(errno));
    out.close_write_end();
    err.close_write_end();
    std::string output, errors;
    drain({out.read_end, err.read_end}, {&output, &errors});
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0)
        return output;
    if (int reason = 0; WIFEXITED(status) && WEXITSTATUS(status) == not_started && errors.size() == sizeof reason) {
        std::memcpy(&reason, errors.data(), sizeof reason);
        throw WorkError(file + ": " + std::strerror(reason));
    }
    const std::string what = quotable(errors.empty() ? program + ": failed without a word" : complaint(errors), 900);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 2)
        throw InputError(what);
    throw WorkError(what);
}

}  // namespace equistream::mitsuba_host
