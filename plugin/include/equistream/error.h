#pragma once
/// Errors for users, each with a message of one line. Programming errors are asserts instead.
#include <stdexcept>
#include <string>

namespace equistream {

/// Bad usage or bad input, found before work began. Programs exit with status 2; the C ABIs return ES_BAD_INPUT.
class InputError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Work had begun and could not be finished (disk full, truncated data, ...). Programs exit with status 1; the C ABIs
/// return ES_FAILED.
class WorkError : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Text from a file or a command line, made safe for a message: control characters become '?', and text beyond
/// `longest_bytes` becomes "...".
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
