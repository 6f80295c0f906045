#pragma once
/// Where viewers come: tcp://, tls:// or srt://.
#include <client/transport/address.h>
#include <client/transport/wire.h>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace equistream::serve {

/// A host is a name or an IP address; none means 127.0.0.1, port 0 any that is free. Throws InputError naming `option`
/// for a host that is not known.
asio::ip::tcp::endpoint resolve(const ServerAddress& address, const std::string& option);

class Door {
public:
    /// Who came, and what it speaks through, which is not open yet.
    struct Guest {
        std::unique_ptr<Wire> wire;
        asio::ip::address address;
        std::uint16_t port = 0;
    };
    using Came = std::function<void(const asio::error_code&, Guest)>;

    virtual ~Door() = default;
    /// Once, before accept(). Throws InputError naming `option` where the address is taken meanwhile.
    virtual void listen(const std::string& option) = 0;
    /// One call waits at a time.
    virtual void accept(Came came) = 0;
    /// Refuses a guest. Its connection is closed now, or a moment later (turned_away.h).
    virtual void turn_away(std::unique_ptr<Wire> wire) = 0;
    /// A call that waits fails, and those turned away are closed.
    virtual void close() = 0;
    virtual bool is_open() const = 0;
    /// Without the secret.
    virtual ServerAddress address() const = 0;
    bool is_local() const { return asio::ip::make_address(address().host).is_loopback(); }
};

/// Bound, not yet listening. `secret` is what those who come to tls:// or srt:// must know. Who vanishes is noticed
/// after `patience_s`. Throws InputError naming `option` where the address is taken or not this machine's.
std::unique_ptr<Door> bind_door(asio::io_context& io, const ServerAddress& address, const std::string& secret,
                                double patience_s, const std::string& option);

/// "192.0.2.1:51234", "[2001:db8::5]:51234"
std::string peer_text(const asio::ip::address& address, std::uint16_t port);

}  // namespace equistream::serve
