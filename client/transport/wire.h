#pragma once
/// Bytes both ways between a server and a client, whatever carries them: TCP, or TLS over TCP or SRT.
///
/// One thread: that of the io_context. Of each kind one call waits at a time. A callback comes from the io_context,
/// never from within the call; after close() with an error. A wire may be destroyed once its callbacks have come. It
/// goes, or is closed, before its io_context does.
#include "received_rate.h"
#include "under_way.h"

#include <asio/error.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>

#include <cstddef>
#include <functional>
#include <memory>
#include <span>

namespace equistream {

/// What Wire::open() fails with over SRT where the other end sends another parity (address.h).
inline constexpr auto other_parity = asio::error::no_protocol_option;

class Wire {
public:
    using Opened = std::function<void(const asio::error_code&)>;
    using Moved = std::function<void(const asio::error_code&, std::size_t)>;

    virtual ~Wire() = default;
    /// Agrees with the other end; before that nothing is read or written.
    virtual void open(Opened opened) = 0;
    /// At least one byte, or an error: asio::error::eof where the other end has said all.
    virtual void read_some(std::span<char> bytes, Moved moved) = 0;
    virtual void write_some(std::span<const char> bytes, Moved moved) = 0;
    /// Of what was written.
    virtual Unacknowledged unacknowledged() = 0;
    /// Says that there will be no more, behind what was written. Reads go on.
    virtual void end_writing() = 0;
    /// What was written and has not arrived yet may be lost.
    virtual void close() = 0;
};

/// Of a connected socket.
std::unique_ptr<Wire> tcp_wire(asio::ip::tcp::socket socket);
/// The same, encrypted.
std::unique_ptr<Wire> tls_wire(asio::ip::tcp::socket socket, std::shared_ptr<asio::ssl::context> context,
                               bool is_server);

/// An end that vanishes is noticed after so long, also while there is nothing to send. Small pieces go at once, little
/// waits in the system, and what is lost on the way does not count as too much (BBR, where the system allows it).
void prepare(asio::ip::tcp::socket& socket, double patience_s);

}  // namespace equistream
