#include "wire.h"

#include "congestion.h"
#include "tls_wire.h"

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

namespace equistream {

namespace {

using asio::ip::tcp;

/// Of patience: how often the other end is asked meanwhile whether it is there.
constexpr double looks = 4;

class TcpWire : public Wire {
public:
    explicit TcpWire(tcp::socket socket) : socket_(std::move(socket)) {}

    void open(Opened opened) override {
        asio::post(socket_.get_executor(), [opened = std::move(opened)] { opened({}); });
    }
    void read_some(std::span<char> bytes, Moved moved) override {
        socket_.async_read_some(asio::buffer(bytes.data(), bytes.size()), std::move(moved));
    }
    void write_some(std::span<const char> bytes, Moved moved) override {
        socket_.async_write_some(asio::buffer(bytes.data(), bytes.size()), std::move(moved));
    }
    Unacknowledged unacknowledged() override { return equistream::unacknowledged(socket_.native_handle()); }
    void end_writing() override {
        asio::error_code ignored;
        socket_.shutdown(tcp::socket::shutdown_send, ignored);
    }
    void close() override {
        asio::error_code ignored;
        socket_.close(ignored);
    }

private:
    tcp::socket socket_;
};

}  // namespace

std::unique_ptr<Wire> tcp_wire(tcp::socket socket) {
    return std::make_unique<TcpWire>(std::move(socket));
}

std::unique_ptr<Wire> tls_wire(tcp::socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server) {
    return std::make_unique<TlsWire<tcp::socket>>(std::move(socket), std::move(context), is_server);
}

void prepare(tcp::socket& socket, double patience_s) {
    asio::error_code ignored;
    socket.set_option(tcp::no_delay(true), ignored);
    // Of a machine that has vanished the system would otherwise go on hoping for a quarter of an hour; while there is
    // nothing to send, for two hours.
    const auto patience_ms = unsigned(patience_s * 1000);
    const int idle_s = std::clamp(int(patience_s / looks), 1, 3600);
    socket.set_option(asio::socket_base::keep_alive(true), ignored);
    setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
    setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_KEEPINTVL, &idle_s, sizeof idle_s);
    setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof patience_ms);
    keep_little_unsent(socket.native_handle());
    use_bbr(socket.native_handle());
}

}  // namespace equistream
