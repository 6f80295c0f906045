#include "wire.h"

#include "congestion.h"

#include <asio/buffer.hpp>
#include <asio/ssl/stream.hpp>

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

/// Kept by its callbacks: what waits in it may end after the wire.
class TlsLine : public std::enable_shared_from_this<TlsLine> {
public:
    TlsLine(tcp::socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server)
        : context_(std::move(context)), is_server_(is_server), stream_(std::move(socket), *context_) {}

    void open(Wire::Opened opened) {
        stream_.async_handshake(
            is_server_ ? asio::ssl::stream_base::server : asio::ssl::stream_base::client,
            [self = shared_from_this(), opened = std::move(opened)](const asio::error_code& error) { opened(error); });
    }
    void read(std::span<char> bytes, Wire::Moved moved) {
        if (has_ended_)
            return pass_over(bytes, std::move(moved));
        stream_.async_read_some(asio::buffer(bytes.data(), bytes.size()),
                                [self = shared_from_this(), bytes,
                                 moved = std::move(moved)](const asio::error_code& error, std::size_t count) {
                                    if (error && error != asio::error::eof && self->has_ended_)
                                        return self->pass_over(bytes, moved);
                                    moved(error, count);
                                });
    }
    void write(std::span<const char> bytes, Wire::Moved moved) {
        stream_.async_write_some(asio::buffer(bytes.data(), bytes.size()),
                                 [self = shared_from_this(), moved = std::move(moved)](
                                     const asio::error_code& error, std::size_t count) { moved(error, count); });
    }
    void end_writing() {
        has_ended_ = true;
        stream_.async_shutdown([self = shared_from_this()](const asio::error_code&) {});
    }
    void close() {
        asio::error_code ignored;
        stream_.lowest_layer().close(ignored);
    }

private:
    /// Once an end has said that it will write no more, OpenSSL takes what still comes for an error. It is read all the
    /// same: closing a socket with something unread takes back what the other end has not read yet.
    void pass_over(std::span<char> bytes, Wire::Moved moved) {
        stream_.next_layer().async_read_some(
            asio::buffer(bytes.data(), bytes.size()),
            [self = shared_from_this(), bytes, moved = std::move(moved)](const asio::error_code& error, std::size_t) {
                if (error)
                    return moved(error, 0);
                self->pass_over(bytes, moved);
            });
    }

    std::shared_ptr<asio::ssl::context> context_;
    bool is_server_, has_ended_ = false;
    asio::ssl::stream<tcp::socket> stream_;
};

class TlsWire : public Wire {
public:
    TlsWire(tcp::socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server)
        : line_(std::make_shared<TlsLine>(std::move(socket), std::move(context), is_server)) {}

    void open(Opened opened) override { line_->open(std::move(opened)); }
    void read_some(std::span<char> bytes, Moved moved) override { line_->read(bytes, std::move(moved)); }
    void write_some(std::span<const char> bytes, Moved moved) override { line_->write(bytes, std::move(moved)); }
    void end_writing() override { line_->end_writing(); }
    void close() override { line_->close(); }

private:
    std::shared_ptr<TlsLine> line_;
};

}  // namespace

std::unique_ptr<Wire> tcp_wire(tcp::socket socket) {
    return std::make_unique<TcpWire>(std::move(socket));
}

std::unique_ptr<Wire> tls_wire(tcp::socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server) {
    return std::make_unique<TlsWire>(std::move(socket), std::move(context), is_server);
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
