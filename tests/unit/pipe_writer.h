#pragma once
/// Who fills a named pipe while a test reads it.
#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <stop_token>
#include <string>
#include <thread>

namespace equistream::test {

/// Writes by a thread of its own, in pieces, and closes the pipe. Made before the reader: where a test fails it gives
/// up as it is destroyed, instead of waiting for somebody who reads.
class PipeWriter {
public:
    PipeWriter(const std::string& pipe, const std::string& bytes, std::size_t piece = 1 << 16)
        : thread_([=](const std::stop_token& stop) { write(pipe, bytes, piece, stop); }) {}

private:
    static void write(const std::string& pipe, const std::string& bytes, std::size_t piece,
                      const std::stop_token& stop) {
        sigset_t broken_pipe;  // a reader that has gone ends the writing, not the tests
        sigemptyset(&broken_pipe);
        sigaddset(&broken_pipe, SIGPIPE);
        pthread_sigmask(SIG_BLOCK, &broken_pipe, nullptr);
        const auto rest = [] { std::this_thread::sleep_for(std::chrono::milliseconds(1)); };
        int descriptor = -1;
        while ((descriptor = ::open(pipe.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK)) < 0 && !stop.stop_requested())
            rest();  // until there is a reader
        for (std::size_t at = 0; descriptor >= 0 && at < bytes.size() && !stop.stop_requested(); rest()) {
            const ssize_t count = ::write(descriptor, &bytes[at], std::min(piece, bytes.size() - at));
            if (count < 0 && errno != EAGAIN && errno != EINTR)
                break;
            at += std::size_t(std::max<ssize_t>(count, 0));
        }
        if (descriptor >= 0)
            ::close(descriptor);
    }

    std::jthread thread_;
};

}  // namespace equistream::test
