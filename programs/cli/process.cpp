#include "process.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>

namespace equistream::cli {

namespace fs = std::filesystem;

namespace {

constexpr std::array ending_signals{SIGINT, SIGTERM, SIGHUP};

void remove_folder(const fs::path& folder) {
    // Another thread may be adding a file: then the folder was not empty at the end.
    for (int tries = 0; tries < 10; ++tries) {
        std::error_code error;
        fs::remove_all(folder, error);
        if (!error)
            return;
    }
}

int to_ending = -1;  ///< a pipe's end, for the handler

extern "C" void tell_ending(int signal) {
    const int before = errno;
    const auto number = static_cast<unsigned char>(signal);
    [[maybe_unused]] const ssize_t written = write(to_ending, &number, 1);
    errno = before;
}

/// When a signal ends the process: says what is to be said, and removes the folders that there are. Never destroyed:
/// its thread ends with the process.
class Ending {
public:
    static Ending& only() {
        static Ending& ending = *new Ending;
        return ending;
    }

    void say(const std::string& line, const fs::path& unfinished) {
        const std::lock_guard lock(mutex_);
        line_ = line;
        unfinished_ = unfinished;
    }

    /// Empty where none can be made.
    fs::path make(std::string name) {
        const std::lock_guard lock(mutex_);
        if (mkdtemp(name.data()) == nullptr)
            return {};
        return *folders_.insert(name).first;
    }

    void remove(const fs::path& folder) {
        const std::lock_guard lock(mutex_);
        folders_.erase(folder);
        remove_folder(folder);
    }

private:
    Ending() {
        int ends[2];
        if (pipe2(ends, O_CLOEXEC) != 0)
            return;  // a folder stays where a signal ends the process
        to_ending = ends[1];
        std::thread([this, from = ends[0]] { wait(from); }).detach();
        for (const int signal : ending_signals)
            take_over(signal);
    }

    /// What a program does with a signal itself, or ignores, is left as it is.
    static void take_over(int signal) {
        struct sigaction now {};
        if (sigaction(signal, nullptr, &now) != 0 || now.sa_handler != SIG_DFL)
            return;
        now.sa_handler = tell_ending;
        now.sa_flags = SA_RESTART;
        sigaction(signal, &now, nullptr);
    }

    void wait(int from) {
        unsigned char signal = 0;
        while (read(from, &signal, 1) != 1)
            if (errno != EINTR)
                return;
        mutex_.lock();  // for good: no folder is made or removed any more
        for (const fs::path& folder : folders_)
            remove_folder(folder);
        std::error_code ignored;
        if (!unfinished_.empty() && fs::file_size(unfinished_, ignored) == 0)
            fs::remove(unfinished_, ignored);
        std::signal(signal, SIG_DFL);
        if (!line_.empty() && signal != SIGHUP) {
            const std::string text = (isatty(STDERR_FILENO) == 1 ? "\n" : "") + line_ + "\n";
            [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, text.data(), text.size());
        }
        raise(signal);
    }

    std::mutex mutex_;
    std::set<fs::path> folders_;
    std::string line_;
    fs::path unfinished_;
};

}  // namespace

ScratchFolder::ScratchFolder(const std::string& program) {
    std::error_code problem;
    const fs::path parent = fs::temp_directory_path(problem);
    if (problem)
        throw WorkError("the folder for temporary files (TMPDIR): " + problem.message());
    const std::string name = (parent / ("equistream-" + program + "-XXXXXX")).string();
    path_ = Ending::only().make(name);
    if (path_.empty())
        throw WorkError(name + ": no folder could be made there");
}

ScratchFolder::~ScratchFolder() {
    Ending::only().remove(path_);
}

void say_at_interrupt(const std::string& line, const fs::path& unfinished) {
    Ending::only().say(line, unfinished);
}

namespace {

std::atomic<bool> was_interrupted = false, was_interrupted_from_keyboard = false;
static_assert(std::atomic<bool>::is_always_lock_free);

extern "C" void note_interrupt(int signal) {
    was_interrupted = true;
    was_interrupted_from_keyboard = was_interrupted_from_keyboard || signal == SIGINT;
    std::signal(signal, SIG_DFL);
}

}  // namespace

void note_interrupts() {
    for (const int signal : {SIGINT, SIGTERM})
        if (std::signal(signal, note_interrupt) == SIG_IGN)
            std::signal(signal, SIG_IGN);
}

const std::atomic<bool>& interrupted() {
    return was_interrupted;
}

void end_by_noted_interrupt() {
    if (was_interrupted_from_keyboard)
        raise(SIGINT);  // its handler is the system's again
}

}  // namespace equistream::cli
