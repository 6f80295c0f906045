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

/// "WHERE: expected EXPECTED, found FOUND", where WHERE is a file, file:line or option.
inline std::string expected_found(const std::string& where, const std::string& expected, const std::string& found) {
    return where + ": expected " + expected + ", found " + found;
}

}  // namespace equistream
