#pragma once
/// One viewer: a connection on which it is sent what its feed gives. Holds one block of it at most, reads what the
/// viewer sends at a bounded rate, and gives up on a viewer that does not read, or not fast enough.
#include "programmes.h"

#include <client/transport/wire.h>
#include <equistream/elapsed.h>

#include <asio/steady_timer.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace equistream::serve {

inline Clock::duration in_clock(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

/// How it goes for a viewer whose feed has a problem.
inline const std::string not_served = "cannot be served further";

class Viewer : public std::enable_shared_from_this<Viewer> {
public:
    /// How it went: "left", "has all", "got nothing", "dropped" or not_served, and details where there are some.
    using Gone = std::function<void(const std::string& how, const std::string& detail)>;

    /// `wire` is open.
    Viewer(const asio::any_io_executor& executor, std::unique_ptr<Wire> wire, std::unique_ptr<Feed> feed,
           double patience_s);

    /// Sends from now on; `gone` is called once, when the connection has been closed.
    void start(Gone gone);
    /// There may be more to send.
    void wake();
    /// Closes the connection, and `gone` is not called any more.
    void stop();
    std::int64_t bytes_sent() const { return bytes_sent_; }

private:
    void send_due();
    void wait_for(double time_s);
    void write(std::size_t begin, std::size_t end);
    void receive();
    void finish();
    void watch();
    void leave(const std::string& how, const std::string& detail = "");
    void leave_with(const asio::error_code& error);
    void drop_idle();
    std::string all_text() const;

    std::unique_ptr<Wire> wire_;
    asio::steady_timer due_, watch_, listening_;
    std::unique_ptr<Feed> feed_;
    double patience_s_;
    Gone gone_;
    Clock::time_point start_;
    std::int64_t bytes_sent_ = 0;
    double block_due_s_ = 0;
    int idle_looks_ = 0, late_looks_ = 0;  // in a row
    bool sends_ = false;                   // a block is on its way
    bool is_held_ = false;                 // the next one waits for what is under way
    std::size_t unacknowledged_ = 0;       // when something was sent last
    bool is_gone_ = false;
    bool has_all_ = false;
    bool has_ended_ = false;  // the viewer's own sending
    std::array<char, 1 << 16> block_;
    std::array<char, 1 << 12> received_;
};

}  // namespace equistream::serve
