#pragma once
/// TLS over anything that Asio's streams can be laid over, as a Wire.
#include "congestion.h"
#include "wire.h"

#include <asio/buffer.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/steady_timer.hpp>

#include <chrono>
#include <cstdint>
#include <utility>

namespace equistream {

/// Kept by its callbacks: what waits in it may end after the wire.
template <typename Socket>
class TlsLine : public std::enable_shared_from_this<TlsLine<Socket>> {
public:
    TlsLine(Socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server)
        : context_(std::move(context)), is_server_(is_server), stream_(std::move(socket), *context_),
          pause_(stream_.get_executor()) {}

    void open(Wire::Opened opened) {
        stream_.async_handshake(is_server_ ? asio::ssl::stream_base::server : asio::ssl::stream_base::client,
                                [self = this->shared_from_this(),
                                 opened = std::move(opened)](const asio::error_code& error) { opened(error); });
    }
    void read(std::span<char> bytes, Wire::Moved moved) {
        if (has_ended_)
            return pass_over(bytes, std::move(moved));
        stream_.async_read_some(asio::buffer(bytes.data(), bytes.size()),
                                [self = this->shared_from_this(), bytes,
                                 moved = std::move(moved)](const asio::error_code& error, std::size_t count) {
                                    if (error && error != asio::error::eof && self->has_ended_)
                                        return self->pass_over(bytes, moved);
                                    moved(error, count);
                                });
    }
    void write(std::span<const char> bytes, Wire::Moved moved) {
        stream_.async_write_some(asio::buffer(bytes.data(), bytes.size()),
                                 [self = this->shared_from_this(), moved = std::move(moved)](
                                     const asio::error_code& error, std::size_t count) { moved(error, count); });
    }
    Unacknowledged unacknowledged() {
        if constexpr (requires { stream_.lowest_layer().native_handle(); })
            return equistream::unacknowledged(stream_.lowest_layer().native_handle());
        else
            return stream_.lowest_layer().unacknowledged();
    }
    void end_writing() {
        has_ended_ = true;
        stream_.async_shutdown([self = this->shared_from_this()](const asio::error_code&) {});
    }
    void close() {
        asio::error_code ignored;
        pause_.cancel();
        stream_.lowest_layer().close(ignored);
    }

private:
    /// Once an end has said that it will write no more, OpenSSL takes what still comes for an error. It is read all the
    /// same: closing a socket with something unread takes back what the other end has not read yet. It is read slowly,
    /// for it may be without end.
    void pass_over(std::span<char> bytes, Wire::Moved moved) {
        stream_.next_layer().async_read_some(asio::buffer(bytes.data(), bytes.size()),
                                             [self = this->shared_from_this(), bytes, moved = std::move(moved)](
                                                 const asio::error_code& error, std::size_t count) {
                                                 if (error)
                                                     return moved(error, 0);
                                                 self->pass_over_later(count, bytes, moved);
                                             });
    }

    void pass_over_later(std::size_t count, std::span<char> bytes, Wire::Moved moved) {
        pause_.expires_after(std::chrono::microseconds(std::int64_t(1e6 * double(count) / received_bytes_per_second)));
        pause_.async_wait(
            [self = this->shared_from_this(), bytes, moved = std::move(moved)](const asio::error_code& over) {
                if (over)
                    return moved(over, 0);
                self->pass_over(bytes, moved);
            });
    }

    std::shared_ptr<asio::ssl::context> context_;
    bool is_server_, has_ended_ = false;
    asio::ssl::stream<Socket> stream_;
    asio::steady_timer pause_;
};

template <typename Socket>
class TlsWire : public Wire {
public:
    TlsWire(Socket socket, std::shared_ptr<asio::ssl::context> context, bool is_server)
        : line_(std::make_shared<TlsLine<Socket>>(std::move(socket), std::move(context), is_server)) {}
    ~TlsWire() override { line_->close(); }

    void open(Opened opened) override { line_->open(std::move(opened)); }
    void read_some(std::span<char> bytes, Moved moved) override { line_->read(bytes, std::move(moved)); }
    void write_some(std::span<const char> bytes, Moved moved) override { line_->write(bytes, std::move(moved)); }
    Unacknowledged unacknowledged() override { return line_->unacknowledged(); }
    void end_writing() override { line_->end_writing(); }
    void close() override { line_->close(); }

private:
    std::shared_ptr<TlsLine<Socket>> line_;
};

}  // namespace equistream
