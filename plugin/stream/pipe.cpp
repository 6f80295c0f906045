#include "pipe.h"

#include "libav.h"

#include <equistream/error.h>
#include <equistream/stream.h>

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

namespace equistream {

namespace {

constexpr int between_questions_ms = 50;

std::optional<int> whole_number(std::string_view digits) {
    int number = 0;
    const char* const end = digits.data() + digits.size();
    const auto [stop, problem] = std::from_chars(digits.data(), end, number);
    return problem == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

/// A pipe that is opened once more does not tell that its writer has gone: such names mean what is open already.
std::optional<int> descriptor_named(std::string_view name) {
    if (name == "/dev/stdin")
        return STDIN_FILENO;
    constexpr std::string_view folder = "/dev/fd/";
    return name.starts_with(folder) ? whole_number(name.substr(folder.size())) : std::nullopt;
}

bool is_named_pipe(const std::string& name) {
    struct stat status;
    return stat(name.c_str(), &status) == 0 && S_ISFIFO(status.st_mode);
}

}  // namespace

bool is_pipe(const std::string& name) {
    return name.starts_with(pipe_scheme) || is_named_pipe(name);
}

std::unique_ptr<Pipe> Pipe::open(const std::string& name) {
    if (name.starts_with(pipe_scheme)) {
        // As libav takes it: what is no number is standard input.
        const int number = whole_number(std::string_view(name).substr(pipe_scheme.size())).value_or(STDIN_FILENO);
        if (number < 0)
            throw InputError(expected_found(name, "the number of an open descriptor", std::to_string(number)));
        return std::unique_ptr<Pipe>(new Pipe(number, false));
    }
    if (!is_named_pipe(name))
        return nullptr;
    const std::optional<int> number = descriptor_named(name);
    const int descriptor =
        number ? fcntl(*number, F_DUPFD_CLOEXEC, 0) : ::open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (descriptor < 0)
        throw InputError(expected_found(name, "a pipe that can be read", std::strerror(errno)));
    return std::unique_ptr<Pipe>(new Pipe(descriptor, true));
}

Pipe::~Pipe() {
    if (is_ours_)
        close(descriptor_);
}

int Pipe::read(std::span<std::uint8_t> bytes, const std::function<bool()>& interrupted) const {
    for (;;) {
        if (interrupted())
            return AVERROR_EXIT;
        // Without a writer so far a pipe is silent, and not at its end.
        pollfd waited_for{descriptor_, POLLIN, 0};
        if (poll(&waited_for, 1, between_questions_ms) <= 0)
            continue;
        const ssize_t count = ::read(descriptor_, bytes.data(), bytes.size());
        if (count >= 0)
            return count == 0 ? AVERROR_EOF : static_cast<int>(count);
        if (errno != EINTR && errno != EAGAIN)
            return AVERROR(errno);
    }
}

}  // namespace equistream
