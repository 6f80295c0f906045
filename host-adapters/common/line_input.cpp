#include "line_input.h"

#include <equistream/error.h>

#include <poll.h>
#include <unistd.h>

namespace equistream::render_command {

namespace {

/// A signal that comes just before the wait does not end it.
constexpr int longest_wait_ms = 500;

}  // namespace

std::optional<std::string> LineInput::next() {
    while (!interrupted_) {
        if (const auto end = read_.find('\n'); end != std::string::npos) {
            std::string line = read_.substr(0, end);
            read_.erase(0, end + 1);
            return line;
        }
        if (read_.size() > longest_line)
            throw WorkError(expected_found(
                "standard input", "lines of at most " + std::to_string(longest_line) + " bytes", "a longer one"));
        pollfd wait{descriptor_, POLLIN, 0};
        if (poll(&wait, 1, longest_wait_ms) <= 0)
            continue;
        char block[1024];
        const ssize_t count = ::read(descriptor_, block, sizeof block);
        if (count <= 0)
            return std::nullopt;
        read_.append(block, static_cast<std::size_t>(count));
    }
    return std::nullopt;
}

bool LineInput::has_ended() const {
    pollfd state{descriptor_, 0, 0};
    return interrupted_ || (poll(&state, 1, 0) > 0 && (state.revents & POLLHUP) != 0);
}

}  // namespace equistream::render_command
