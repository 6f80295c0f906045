#include "door.h"

#include "turned_away.h"

#include <client/transport/secret.h>
#include <client/transport/srt_wire.h>
#include <programs/cli/program.h>

#include <equistream/error.h>
#include <equistream/text.h>

#include <asio/ip/udp.hpp>

#include <utility>

namespace equistream::serve {

using asio::ip::tcp;

namespace {

void require_free(const std::string& where, const asio::error_code& error) {
    cli::require(!error, where, "a free address of this machine", error.message());
}

ServerAddress address_of(Scheme scheme, const auto& endpoint) {
    return {.scheme = scheme, .host = endpoint.address().to_string(), .port = endpoint.port()};
}

/// TCP, or TLS over it.
class TcpDoor : public Door {
public:
    TcpDoor(asio::io_context& io, const ServerAddress& address, const std::string& secret, double patience_s,
            const std::string& option)
        : acceptor_(io), turned_away_(io.get_executor(), max_turned_away()), scheme_(address.scheme),
          patience_s_(patience_s) {
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

    void listen(const std::string& option) override {
        asio::error_code error;
        acceptor_.listen(asio::socket_base::max_listen_connections, error);
        require_free(option + " " + address().text(), error);
    }
    void accept(Came came) override {
        acceptor_.async_accept([this, came = std::move(came)](const asio::error_code& error, tcp::socket socket) {
            if (error)
                turned_away_.clear();  // it may want what they hold
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
    void turn_away(std::unique_ptr<Wire> wire) override { turned_away_.add(std::move(wire)); }
    void close() override {
        asio::error_code ignored;
        acceptor_.close(ignored);
        turned_away_.clear();
    }
    bool is_open() const override { return acceptor_.is_open(); }
    ServerAddress address() const override { return address_of(scheme_, acceptor_.local_endpoint()); }

private:
    tcp::acceptor acceptor_;
    TurnedAway turned_away_;
    Scheme scheme_;
    double patience_s_;
    std::shared_ptr<asio::ssl::context> context_;  // null: not encrypted
};

auto or_taken(const std::string& where, auto call) {
    try {
        return call();
    } catch (const WorkError& error) {
        throw InputError(expected_found(where, "a free address of this machine", error.what()));
    }
}

class SrtDoor : public Door {
public:
    SrtDoor(asio::io_context& io, const ServerAddress& address, const std::string& secret, double patience_s,
            const std::string& option)
        : listener_(or_taken(option + " " + address.text(),
                             [&] {
                                 const tcp::endpoint endpoint = resolve(address, option);
                                 return std::make_unique<SrtListener>(
                                     io.get_executor(), asio::ip::udp::endpoint(endpoint.address(), endpoint.port()),
                                     secret_context(secret, TlsRole::server), patience_s,
                                     address.parity.value_or(usual_parity));
                             })),
          address_(address_of(Scheme::srt, listener_->address())) {
        address_.parity = address.parity;
    }

    void listen(const std::string& option) override {
        or_taken(option + " " + address_.text(), [this] {
            listener_->listen();
            return 0;
        });
    }
    void accept(Came came) override {
        listener_->accept(
            [came = std::move(came)](const asio::error_code& error, std::unique_ptr<Wire> wire, const auto& peer) {
                came(error, {std::move(wire), peer.address(), peer.port()});
            });
    }
    /// Closed at once: whoever comes again has to shake hands first.
    void turn_away(std::unique_ptr<Wire>) override {}
    void close() override { listener_->close(); }
    bool is_open() const override { return listener_->is_open(); }
    ServerAddress address() const override { return address_; }

private:
    std::unique_ptr<SrtListener> listener_;
    ServerAddress address_;
};

}  // namespace

tcp::endpoint resolve(const ServerAddress& address, const std::string& option) {
    if (address.host.empty())
        return {asio::ip::address_v4::loopback(), address.port};
    asio::io_context io;
    tcp::resolver resolver(io);
    asio::error_code error;
    const auto found = resolver.resolve(address.host, std::to_string(address.port), tcp::resolver::passive, error);
    cli::require(!error && !found.empty(), option + " " + address.text(), "a host name that resolves", error.message());
    return found.begin()->endpoint();
}

std::unique_ptr<Door> bind_door(asio::io_context& io, const ServerAddress& address, const std::string& secret,
                                double patience_s, const std::string& option) {
    if (address.scheme == Scheme::srt)
        return std::make_unique<SrtDoor>(io, address, secret, patience_s, option);
    return std::make_unique<TcpDoor>(io, address, secret, patience_s, option);
}

std::string peer_text(const asio::ip::address& address, std::uint16_t port) {
    const std::string host = address.to_string();
    return (address.is_v6() ? "[" + host + "]" : host) + ":" + std::to_string(port);
}

}  // namespace equistream::serve
