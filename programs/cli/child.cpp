#include "child.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <thread>

namespace equistream::cli {

namespace {

/// Exit status of a child whose program could not be started, and wrote errno to standard error; shells use it too.
constexpr int not_started = 127;

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

/// When a child has had its time; never where it has no limit.
class Deadline {
public:
    explicit Deadline(std::optional<double> limit_s) : limit_s_(limit_s) {}
    bool is_over() const { return limit_s_ && seconds_since(start_) >= *limit_s_; }
    /// For poll().
    int milliseconds_left() const {
        return limit_s_ ? int(std::ceil(1e3 * std::clamp(*limit_s_ - seconds_since(start_), 0.0, 1e5))) : -1;
    }

private:
    Clock::time_point start_ = Clock::now();
    std::optional<double> limit_s_;
};

/// Reads both until they are closed, so that neither can fill up and block the writer. False: the time was over.
bool drain(const std::array<int, 2>& ends, const std::array<std::string*, 2>& texts, const Deadline& deadline) {
    std::array<pollfd, 2> waiting{pollfd{ends[0], POLLIN, 0}, pollfd{ends[1], POLLIN, 0}};
    int open = 2;
    while (open > 0) {
        if (deadline.is_over())
            return false;
        const int ready = poll(waiting.data(), waiting.size(), deadline.milliseconds_left());
        if (ready < 0 && errno != EINTR)
            break;
        for (std::size_t i = 0; ready > 0 && i < waiting.size(); ++i) {
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
    return true;
}

/// False: the time was over.
bool wait_for(pid_t child, int& status, const Deadline& deadline) {
    for (;;) {
        const pid_t ended = waitpid(child, &status, deadline.milliseconds_left() < 0 ? 0 : WNOHANG);
        if (ended == child)
            return true;
        if (ended < 0 && errno != EINTR)
            throw WorkError(std::string("waiting for a started program failed: ") + std::strerror(errno));
        if (deadline.is_over())
            return false;
        if (ended == 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
}

[[noreturn]] void become(char* const* words, const Pipe& out, const Pipe& err, pid_t parent, bool own_group) {
    if (own_group)
        setpgid(0, 0);
    if (prctl(PR_SET_PDEATHSIG, SIGTERM) == 0 && getppid() == parent && dup2(out.write_end, STDOUT_FILENO) >= 0 &&
        dup2(err.write_end, STDERR_FILENO) >= 0)
        execv(words[0], words);
    const int reason = errno;
    _exit(write(err.write_end, &reason, sizeof reason) == sizeof reason ? not_started : EXIT_FAILURE);
}

}  // namespace

ChildEnd run_child(const std::vector<std::string>& words, std::optional<double> limit_s) {
    std::vector<char*> argv;
    for (const std::string& word : words)
        argv.push_back(const_cast<char*>(word.c_str()));
    argv.push_back(nullptr);
    Pipe out, err;
    std::signal(SIGCHLD, SIG_DFL);  // a program that is started with it ignored could wait for no child
    const pid_t parent = getpid();
    const pid_t child = fork();
    if (child == 0)
        become(argv.data(), out, err, parent, limit_s.has_value());
    if (child < 0)
        throw WorkError(words[0] + ": " + std::strerror(errno));
    if (limit_s)
        setpgid(child, child);  // whichever of the two comes first
    out.close_write_end();
    err.close_write_end();
    const Deadline deadline(limit_s);
    ChildEnd end;
    int status = 0;
    if (!drain({out.read_end, err.read_end}, {&end.output, &end.errors}, deadline) ||
        !wait_for(child, status, deadline)) {
        end.was_too_slow = true;
        kill(-child, SIGKILL);
        wait_for(child, status, Deadline({}));
    }
    if (WIFEXITED(status))
        end.exit_code = WEXITSTATUS(status);
    else if (WIFSIGNALED(status) && !end.was_too_slow)
        end.signal = WTERMSIG(status);
    if (int reason = 0; end.exit_code == not_started && end.errors.size() == sizeof reason) {
        std::memcpy(&reason, end.errors.data(), sizeof reason);
        throw WorkError(words[0] + ": " + std::strerror(reason));
    }
    return end;
}

}  // namespace equistream::cli
