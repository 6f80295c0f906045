#include "door.h"

#include <client/transport/secret.h>
#include <client/transport/srt_wire.h>
#include <programs/cli/program.h>

#include <equistream/error.h>

#include <asio/ip/tcp.hpp>
#include <netinet/tcp.h>

#include <optional>
#include <utility>

namespace equistream::serve {

using asio::ip::tcp;
using asio::ip::udp;

namespace {

/// What the system keeps for a viewer beyond what is on its way: more would only be older when it comes.
constexpr int max_unsent_bytes = 1 << 17;

ServerAddress address_of(Scheme scheme, const auto& endpoint) {
    return {.scheme = scheme, .host = endpoint.address().to_string(), .port = endpoint.port()};
}

class TcpDoor : public Door {
public:
    TcpDoor(asio::io_context& io, const ServerAddress& address, const std::string& secret, double patience_s,
            const std::string& option)
        : acceptor_(io), scheme_(address.scheme), patience_s_(patience_s) {
        const tcp::endpoint endpoint = resolve(address, option);
        asio::error_code error;
        acceptor_.open(endpoint.protocol(), error);
        if (!error)
            acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
        if (!error)
            acceptor_.bind(endpoint, error);
        require_free(option, error);
        if (scheme_ == Scheme::tls)
            context_ = secret_context(secret, TlsRole::server);
    }

    void listen(const std::string& option) override {
        asio::error_code error;
        acceptor_.listen(asio::socket_base::max_listen_connections, error);
        require_free(option, error);
    }
    void accept(Came came) override {
        acceptor_.async_accept([this, came = std::move(came)](const asio::error_code& error, tcp::socket socket) {
            if (error || !acceptor_.is_open())
                return came(error ? error : asio::error_code(asio::error::operation_aborted), {});
            asio::error_code gone;
            const tcp::endpoint peer = socket.remote_endpoint(gone);
            if (gone)  // it has hung up already
                return accept(came);
            set_patience(socket, patience_s_);
            setsockopt(socket.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent_bytes,
                       sizeof max_unsent_bytes);
            auto wire = context_ ? tls_wire(std::move(socket), context_, true) : tcp_wire(std::move(socket));
            came({}, {std::move(wire), peer.address(), peer.port()});
        });
    }
    void close() override {
        asio::error_code ignored;
        acceptor_.close(ignored);
    }
    bool is_open() const override { return acceptor_.is_open(); }
    ServerAddress address() const override { return address_of(scheme_, acceptor_.local_endpoint()); }
    bool is_local() const override { return acceptor_.local_endpoint().address().is_loopback(); }

private:
    void require_free(const std::string& option, const asio::error_code& error) const {
        cli::require(!error, option, "an address that is free and this machine's", error.message());
    }

    tcp::acceptor acceptor_;
    Scheme scheme_;
    double patience_s_;
    std::shared_ptr<asio::ssl::context> context_;  // null: not encrypted
};

class SrtDoor : public Door {
public:
    SrtDoor(asio::io_context& io, const ServerAddress& address, const SrtSettings& settings,
            const std::string& option) {
        const tcp::endpoint endpoint = resolve(address, option);
        try {
            listener_.emplace(io.get_executor(), udp::endpoint(endpoint.address(), endpoint.port()), settings);
        } catch (const WorkError& error) {
            throw InputError(expected_found(option, "an address that is free and this machine's", error.what()));
        }
    }

    void listen(const std::string&) override { listener_->listen(); }
    void accept(Came came) override {
        listener_->accept([came = std::move(came)](const asio::error_code& error, std::unique_ptr<Wire> wire,
                                                   const udp::endpoint& peer) {
            came(error, {std::move(wire), peer.address(), peer.port()});
        });
    }
    void close() override { listener_->close(); }
    bool is_open() const override { return listener_->is_open(); }
    ServerAddress address() const override { return address_of(Scheme::srt, listener_->address()); }
    bool is_local() const override { return listener_->address().address().is_loopback(); }

private:
    std::optional<SrtListener> listener_;
};

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

std::unique_ptr<Door> bind_door(asio::io_context& io, const ServerAddress& address, const std::string& secret,
                                double patience_s, double mbit_s, const std::string& option) {
    const std::string where = option + " " + address.text();
    if (address.scheme == Scheme::srt)
        return std::make_unique<SrtDoor>(io, address, SrtSettings{secret, patience_s, mbit_s}, where);
    return std::make_unique<TcpDoor>(io, address, secret, patience_s, where);
}

std::string peer_text(const asio::ip::address& address, std::uint16_t port) {
    const std::string host = address.to_string();
    return (address.is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace equistream::serve
