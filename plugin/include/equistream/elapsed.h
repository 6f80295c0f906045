#pragma once
/// Wall time since a moment, which never goes back, and how long a server is waited for.
#include <chrono>

namespace equistream {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

inline double milliseconds_since(Clock::time_point start) {
    return 1e3 * seconds_since(start);
}

// How long a client waits for a server. `equistream serve` sends something every second once it has sent its header.

struct Patience {
    double connect_s = 10;      ///< for a connection
    double first_bytes_s = 30;  ///< for the first byte: a live server has none before its first sphere is rendered
    double silence_s = 10;      ///< for each one after that
};

}  // namespace equistream
