#pragma once
/// How long a client waits for a server. `equistream serve` sends something every second once it has sent its header.

namespace equistream {

struct Patience {
    double connect_s = 10;      ///< for a connection
    double first_bytes_s = 30;  ///< for the first byte: a live server has none before its first sphere is rendered
    double silence_s = 10;      ///< for each one after that
};

}  // namespace equistream
