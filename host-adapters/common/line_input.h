#pragma once
/// Lines of a file descriptor on which another process writes when it likes.
#include <atomic>
#include <cstddef>
#include <optional>
#include <string>

namespace equistream::render_command {

class LineInput {
public:
    /// `interrupted` is borrowed; waiting ends soon after it is set.
    LineInput(int descriptor, const std::atomic<bool>& interrupted)
        : descriptor_(descriptor), interrupted_(interrupted) {}

    /// The next line without its end, waited for; nothing where they have ended, or at an interrupt. Throws WorkError
    /// for one that is longer than any order.
    std::optional<std::string> next();
    /// Whether nobody writes any more, or there was an interrupt. Any thread may ask.
    bool has_ended() const;

private:
    static constexpr std::size_t longest_line = 4096;

    int descriptor_;
    const std::atomic<bool>& interrupted_;
    std::string read_;  // beyond the last line given
};

}  // namespace equistream::render_command
