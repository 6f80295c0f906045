#pragma once
/// Elapsed time on a monotonic clock, and timeouts for servers.
#include <chrono>

namespace equistream {

using Clock = std::chrono::steady_clock;

inline double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

inline double milliseconds_since(Clock::time_point start) {
    return 1e3 * seconds_since(start);
}

/// How long a client waits for a server. `equistream serve` sends something every second once it has sent its header.
struct Patience {
    double connect_s = 10;      ///< for a connection
    double first_bytes_s = 30;  ///< for the first byte: a live server sends none before its first sphere is rendered
    double silence_s = 10;      ///< for each further byte
};

}  // namespace equistream
