#pragma once
/// One viewer: a connection on which a recording is sent in time. Holds one block of it at most, reads what the viewer
/// sends at a bounded rate and drops it, and gives up on a viewer that does not read.
#include "recording.h"

#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include <array>
#include <functional>
#include <memory>
#include <string>

namespace equistream::serve {

struct ViewerSettings {
    bool loop = false;
    double patience_s = 10;
};

class Viewer : public std::enable_shared_from_this<Viewer> {
public:
    /// How it went: "left", "has all", "dropped", ..., and details where there are some.
    using Gone = std::function<void(const std::string& how, const std::string& detail)>;

    /// `recording` must outlive it.
    Viewer(asio::ip::tcp::socket socket, const Recording& recording, const ViewerSettings& settings);

    /// Sends from now on; `gone` is called once, when the connection has been closed.
    void start(Gone gone);
    /// Closes the connection, and `gone` is not called any more.
    void stop();
    std::int64_t bytes_sent() const { return bytes_sent_; }

private:
    double elapsed_s() const;
    void send_due();
    void wait_for(double time_s);
    void write(std::size_t begin, std::size_t end);
    void receive();
    void finish();
    void be_patient();
    void leave(const std::string& how, const std::string& detail = "");
    void leave_with(const asio::error_code& error);
    void drop();

    asio::ip::tcp::socket socket_;
    asio::steady_timer due_, patience_, listening_;
    const Recording& recording_;
    ViewerSettings settings_;
    Gone gone_;
    std::chrono::steady_clock::time_point start_;
    double round_start_s_ = 0;   // of this repetition
    std::int64_t position_ = 0;  // in the recording
    std::int64_t bytes_sent_ = 0;
    bool is_gone_ = false;
    bool has_all_ = false;
    bool has_ended_ = false;  // the viewer's own sending
    std::array<char, 1 << 16> block_;
    std::array<char, 1 << 12> received_;
};

}  // namespace equistream::serve
