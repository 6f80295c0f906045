#pragma once
/// One SRT socket, and a stream of bytes over it as Asio's are, for TLS to lie over.
#include "delivery_window.h"
#include "srt_reactor.h"
#include "wire.h"

#include <equistream/elapsed.h>

#include <asio/async_result.hpp>
#include <asio/buffer.hpp>
#include <asio/ip/udp.hpp>
#include <asio/steady_timer.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace equistream {

/// What fits into a packet on any line: packets that are divided on the way are lost more often.
inline constexpr std::size_t srt_payload_bytes = 1316;

/// With all that both ends say of a connection; `connect_s` is for making one. Forward error correction: packets stand
/// in rows and columns of `parity` each, and every row and every column has a packet of parity (as in SMPTE ST 2022-1).
/// Throws WorkError.
SRTSOCKET make_srt_socket(double patience_s, double connect_s, int parity);

/// In the io_context's thread, as a Wire; but several reads may wait. Its callbacks keep it until close().
class SrtLine : public std::enable_shared_from_this<SrtLine> {
public:
    /// Ends where more than `max_unread_bytes` have come and were not read.
    SrtLine(const asio::any_io_executor& executor, SRTSOCKET socket, std::size_t max_unread_bytes);
    ~SrtLine() { close(); }
    SrtLine(const SrtLine&) = delete;
    SrtLine& operator=(const SrtLine&) = delete;

    const asio::any_io_executor& executor() const { return executor_; }
    void connect(const asio::ip::udp::endpoint& server, Wire::Opened connected);
    /// Ends with asio::error::eof where the other end has gone, however it went.
    void read(std::span<char> bytes, Wire::Moved moved);
    /// Not one byte alone.
    void write(std::span<const char> bytes, Wire::Moved moved);
    Unacknowledged unacknowledged() const { return {unacknowledged_bytes(), window_.acknowledged_after_s()}; }
    void close();

private:
    struct Read {
        std::span<char> bytes;
        Wire::Moved moved;
    };

    void drain();
    void drain_soon();
    void serve_reads();
    std::size_t unacknowledged_bytes() const;
    void keep_looking();
    void look();
    void run_writes();
    void finish(Wire::Moved moved, const asio::error_code& error, std::size_t count);

    asio::any_io_executor executor_;
    std::shared_ptr<SrtReactor> reactor_ = SrtReactor::get();
    SRTSOCKET socket_;
    bool is_closed_ = false;

    std::size_t max_unread_bytes_;
    std::vector<char> unread_;  // from unread_begin_ on
    std::size_t unread_begin_ = 0;
    std::deque<Read> reads_;
    bool drains_ = false, has_ended_ = false;  // the other end has gone
    asio::steady_timer poll_;
    bool polls_ = false;
    Clock::time_point received_{};

    std::vector<std::function<void()>> writes_;  // what goes on when it can
    asio::steady_timer look_;
    bool looks_ = false, has_waited_ = false;  // a write, since the last look
    DeliveryWindow window_;
    Clock::time_point start_ = Clock::now(), wrote_{};
    std::uint64_t written_bytes_ = 0;
};

/// An AsyncReadStream and AsyncWriteStream.
class SrtStream {
public:
    using executor_type = asio::any_io_executor;
    using lowest_layer_type = SrtStream;

    explicit SrtStream(std::shared_ptr<SrtLine> line) : line_(std::move(line)) {}
    executor_type get_executor() const { return line_->executor(); }
    lowest_layer_type& lowest_layer() { return *this; }
    const lowest_layer_type& lowest_layer() const { return *this; }
    void close(asio::error_code& error) {
        error = {};
        line_->close();
    }

    Unacknowledged unacknowledged() const { return line_->unacknowledged(); }

    template <typename Buffers, typename Token>
    auto async_read_some(const Buffers& buffers, Token&& token) {
        return asio::async_initiate<Token, void(asio::error_code, std::size_t)>(
            [line = line_](auto handler, const auto& into) {
                const asio::mutable_buffer first = first_of<asio::mutable_buffer>(into);
                line->read({static_cast<char*>(first.data()), first.size()}, moved_by(std::move(handler)));
            },
            token, buffers);
    }
    template <typename Buffers, typename Token>
    auto async_write_some(const Buffers& buffers, Token&& token) {
        return asio::async_initiate<Token, void(asio::error_code, std::size_t)>(
            [line = line_](auto handler, const auto& from) {
                const asio::const_buffer first = first_of<asio::const_buffer>(from);
                line->write({static_cast<const char*>(first.data()), first.size()}, moved_by(std::move(handler)));
            },
            token, buffers);
    }

private:
    /// The first that is not empty.
    template <typename Buffer, typename Buffers>
    static Buffer first_of(const Buffers& buffers) {
        for (auto buffer = asio::buffer_sequence_begin(buffers); buffer != asio::buffer_sequence_end(buffers); ++buffer)
            if (Buffer(*buffer).size() > 0)
                return *buffer;
        return {};
    }
    /// Handlers of Asio's cannot be copied, as a std::function must be.
    template <typename Handler>
    static Wire::Moved moved_by(Handler handler) {
        return [kept = std::make_shared<Handler>(std::move(handler))](const asio::error_code& error,
                                                                      std::size_t count) { (*kept)(error, count); };
    }

    std::shared_ptr<SrtLine> line_;
};

}  // namespace equistream
