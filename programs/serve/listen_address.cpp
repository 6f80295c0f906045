#include "listen_address.h"

#include <equistream/error.h>

#include <asio/io_context.hpp>

#include <charconv>
#include <cstdint>
#include <string_view>

namespace equistream::serve {

namespace {

using asio::ip::tcp;

struct HostAndPort {
    std::string host;
    std::uint16_t port = 0;
};

HostAndPort split(const std::string& url, const std::string& option) {
    constexpr std::string_view scheme = "tcp://";
    const auto refuse = [&] {
        return InputError(expected_found(option, "tcp://HOST:PORT with a port of 0 to 65535", "'" + url + "'"));
    };
    const auto colon = url.rfind(':');
    if (!url.starts_with(scheme) || colon < scheme.size())
        throw refuse();
    HostAndPort found;
    const char* const end = url.data() + url.size();
    const auto [stop, error] = std::from_chars(url.data() + colon + 1, end, found.port);
    if (error != std::errc() || stop != end)
        throw refuse();
    found.host = url.substr(scheme.size(), colon - scheme.size());
    if (found.host.starts_with('[') && found.host.ends_with(']'))
        found.host = found.host.substr(1, found.host.size() - 2);
    else if (found.host.find_first_of("/:[]") != std::string::npos)
        throw refuse();
    return found;
}

}  // namespace

tcp::endpoint parse_listen_address(const std::string& url, const std::string& option) {
    const HostAndPort wanted = split(url, option);
    if (wanted.host.empty())
        return {asio::ip::address_v4::loopback(), wanted.port};
    asio::io_context io;
    tcp::resolver resolver(io);
    asio::error_code error;
    const auto found = resolver.resolve(wanted.host, std::to_string(wanted.port), tcp::resolver::passive, error);
    if (error || found.empty())
        throw InputError(expected_found(option + " " + url, "a host that is known here", error.message()));
    return found.begin()->endpoint();
}

tcp::acceptor bind_to(asio::io_context& io, const tcp::endpoint& address, const std::string& option) {
    tcp::acceptor acceptor(io);
    asio::error_code error;
    acceptor.open(address.protocol(), error);
    if (!error)
        acceptor.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
        acceptor.bind(address, error);
    if (error)
        throw InputError(expected_found(option + " " + url_of(address), "an address that is free and this machine's",
                                        error.message()));
    return acceptor;
}

std::string url_of(const tcp::endpoint& address) {
    const std::string host = address.address().to_string();
    return "tcp://" + (address.address().is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(address.port());
}

}  // namespace equistream::serve
