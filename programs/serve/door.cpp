#include "door.h"

#include <client/transport/secret.h>
#include <programs/cli/program.h>

#include <utility>

namespace equistream::serve {

using asio::ip::tcp;

namespace {

void require_free(const std::string& where, const asio::error_code& error) {
    cli::require(!error, where, "an address that is free and this machine's", error.message());
}

}  // namespace

tcp::endpoint resolve(const ServerAddress& address, const std::string& option) {
    if (address.host.empty())
        return {asio::ip::address_v4::loopback(), address.port};
    asio::io_context io;
    tcp::resolver resolver(io);
    asio::error_code error;
    const auto found = resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
    cli::require(!error && !found.empty(), option + " " + address.text(), "a host that is known here", error.message());
    return found.begin()->endpoint();
}

Door::Door(asio::io_context& io, const ServerAddress& address, const std::string& secret, double patience_s,
           const std::string& option)
    : acceptor_(io), scheme_(address.scheme), patience_s_(patience_s) {
    const tcp::endpoint endpoint = resolve(address, option);
    asio::error_code error;
    acceptor_.open(endpoint.protocol(), error);
    if (!error)
        acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error)
        acceptor_.bind(endpoint, error);
    require_free(option + " " + address.text(), error);
    if (is_encrypted(scheme_))
        context_ = secret_context(secret, TlsRole::server);
}

void Door::listen(const std::string& option) {
    asio::error_code error;
    acceptor_.listen(asio::socket_base::max_listen_connections, error);
    require_free(option + " " + address().text(), error);
}

void Door::accept(Came came) {
    acceptor_.async_accept([this, came = std::move(came)](const asio::error_code& error, tcp::socket socket) {
        if (error || !acceptor_.is_open())
            return came(error ? error : asio::error_code(asio::error::operation_aborted), {});
        asio::error_code gone;
        const tcp::endpoint peer = socket.remote_endpoint(gone);
        if (gone)  // it has hung up already
            return accept(came);
        prepare(socket, patience_s_);
        auto wire = context_ ? tls_wire(std::move(socket), context_, true) : tcp_wire(std::move(socket));
        came({}, {std::move(wire), peer.address(), peer.port()});
    });
}

void Door::close() {
    asio::error_code ignored;
    acceptor_.close(ignored);
}

ServerAddress Door::address() const {
    const tcp::endpoint endpoint = acceptor_.local_endpoint();
    return {.scheme = scheme_, .host = endpoint.address().to_string(), .port = endpoint.port()};
}

std::string peer_text(const asio::ip::address& address, std::uint16_t port) {
    const std::string host = address.to_string();
    return (address.is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace equistream::serve
