#pragma once
/// Refused connections, kept open for a moment. Clients that reconnect as soon as they are refused would keep the
/// server busy: 500 of them made 6,400 connections a second. One thread: that of `executor`.
#include <client/transport/wire.h>

#include <asio/any_io_executor.hpp>
#include <asio/steady_timer.hpp>

#include <chrono>
#include <cstddef>
#include <deque>
#include <memory>

namespace equistream::serve {

class TurnedAway {
public:
    using Clock = asio::steady_timer::clock_type;
    static constexpr std::chrono::milliseconds held_for{1000};

    /// Holds `max_held` at a time.
    TurnedAway(const asio::any_io_executor& executor, std::size_t max_held);

    /// Where there are as many already, the connection is closed at once.
    void add(std::unique_ptr<Wire> wire);
    /// Closes all.
    void clear();

private:
    struct Held {
        Clock::time_point until;
        std::unique_ptr<Wire> wire;
    };

    void wait();

    std::size_t max_held_;
    std::deque<Held> held_;  ///< the oldest first
    asio::steady_timer timer_;
};

/// Half of the files that this process may have open, 512 at most.
std::size_t max_turned_away();

}  // namespace equistream::serve
