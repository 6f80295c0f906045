#pragma once
/// Errors that a person can mend. Programmer errors are asserts; these two are what the user sees, one line each.
#include <stdexcept>
#include <string>

namespace equistream {

/// Bad usage or bad input found before work began: the program exits 2.
class InputError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Work had begun and could not be finished (disk full, truncated data, ...): the program exits 1.
class WorkError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Text out of a file or a command line as a message may hold it: what would break the line or drive a terminal is
/// shown as '?', and what is too long to be read is cut.
inline std::string quotable(std::string text, std::size_t longest_bytes) {
    for (char& c : text)
        if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
            c = '?';
    return text.size() <= longest_bytes ? text : text.substr(0, longest_bytes) + "...";
}

/// "WHERE: expected EXPECTED, found FOUND", where WHERE is a file, file:line or option. Always one line.
inline std::string expected_found(const std::string& where, const std::string& expected, const std::string& found) {
    return quotable(where, 4096) + ": expected " + quotable(expected, 4096) + ", found " + quotable(found, 300);
}

}  // namespace equistream
