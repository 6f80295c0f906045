#pragma once
/// Where the server listens: tcp://HOST:PORT.
#include <asio/ip/tcp.hpp>

#include <string>

namespace equistream::serve {

/// A host is a name, an IPv4 address or an IPv6 address in brackets; none means 127.0.0.1, port 0 any that is free.
/// Throws InputError naming `option` for what is none of these, and for a host that is not known.
asio::ip::tcp::endpoint parse_listen_address(const std::string& url, const std::string& option);

/// Bound, not yet listening. Throws InputError where the address is taken or not this machine's.
asio::ip::tcp::acceptor bind_to(asio::io_context& io, const asio::ip::tcp::endpoint& address,
                                const std::string& option);

/// "tcp://127.0.0.1:9000"
std::string url_of(const asio::ip::tcp::endpoint& address);

}  // namespace equistream::serve
