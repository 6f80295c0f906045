#pragma once
/// Programs that are run as children, waited for and listened to.
#include <optional>
#include <string>
#include <vector>

namespace equistream::cli {

/// How a child ended, and what it said.
struct ChildEnd {
    std::string output, errors;  ///< standard output and standard error
    int exit_code = -1;          ///< -1: it did not exit by itself
    int signal = 0;              ///< that ended it; 0: none
    bool was_too_slow = false;   ///< it was ended at its time limit

    bool is_good() const { return exit_code == 0 && !was_too_slow; }
};

/// Runs words[0], a path, with these words, and waits until it has ended. A child with a limit has a process group of
/// its own, which is ended with it when so many seconds have passed. Every child is told to end where this process
/// does. Throws WorkError where it cannot be started.
ChildEnd run_child(const std::vector<std::string>& words, std::optional<double> limit_s = {});

}  // namespace equistream::cli
