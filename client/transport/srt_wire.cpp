#include "srt_wire.h"

#include "srt_line.h"
#include "tls_wire.h"

#include <equistream/error.h>

#include <asio/error.hpp>
#include <asio/post.hpp>

#include <cstring>
#include <optional>
#include <utility>

namespace equistream {

namespace {

using asio::ip::udp;

/// Whoever watches is sent much, and sends little.
constexpr std::size_t unread_by_client_bytes = 16 << 20, unread_by_server_bytes = 1 << 18;
constexpr int backlog = 64;

class SrtWire : public TlsWire<SrtStream> {
public:
    /// `server`: nothing where it is connected already.
    SrtWire(std::shared_ptr<SrtLine> line, std::shared_ptr<asio::ssl::context> context,
            const std::optional<udp::endpoint>& server)
        : TlsWire(SrtStream(line), std::move(context), !server), line_(std::move(line)), server_(server) {}

    void open(Opened opened) override {
        if (!server_)
            return TlsWire::open(std::move(opened));
        line_->connect(*server_, [this, opened = std::move(opened)](const asio::error_code& error) {
            if (error)
                return opened(error);
            TlsWire::open(opened);
        });
    }

private:
    std::shared_ptr<SrtLine> line_;
    std::optional<udp::endpoint> server_;
};

[[noreturn]] void fail_with_last() {
    throw WorkError(srt_getlasterror_str());
}

}  // namespace

std::unique_ptr<Wire> srt_wire(const asio::any_io_executor& executor, const udp::endpoint& server,
                               std::shared_ptr<asio::ssl::context> context, double patience_s, double connect_s,
                               int parity) {
    const auto started = SrtReactor::get();  // the library, before a socket is made
    return std::make_unique<SrtWire>(
        std::make_shared<SrtLine>(executor, make_srt_socket(patience_s, connect_s, parity), unread_by_client_bytes),
        std::move(context), server);
}

class SrtListener::State : public std::enable_shared_from_this<State> {
public:
    State(const asio::any_io_executor& executor, const udp::endpoint& address,
          std::shared_ptr<asio::ssl::context> context, double patience_s, int parity)
        : executor_(executor), context_(std::move(context)), socket_(make_srt_socket(patience_s, patience_s, parity)) {
        const int ipv6_alone = 0;
        if ((!address.address().is_v6() ||
             srt_setsockflag(socket_, SRTO_IPV6ONLY, &ipv6_alone, sizeof ipv6_alone) >= 0) &&
            srt_bind(socket_, address.data(), int(address.size())) >= 0)
            return;
        const std::string reason = srt_getlasterror_str();
        srt_close(socket_);
        throw WorkError(reason);
    }

    void listen() const {
        if (srt_listen(socket_, backlog) < 0)
            fail_with_last();
    }

    void accept(Accepted accepted) {
        if (is_closed_)
            return finish(std::move(accepted), asio::error::operation_aborted, SRT_INVALID_SOCK, {});
        waiting_ = std::move(accepted);
        if (take_guest())
            return;
        reactor_->wait(socket_, SrtReactor::Direction::read, executor_, [self = shared_from_this()] {
            if (auto waiting = std::exchange(self->waiting_, nullptr))
                self->accept(std::move(waiting));
        });
        // Who came before that would be told with the next guest.
        if (take_guest())
            reactor_->forget(socket_);
    }

    void close() {
        if (std::exchange(is_closed_, true))
            return;
        reactor_->forget(socket_);
        srt_close(socket_);
        if (auto waiting = std::exchange(waiting_, nullptr))
            finish(std::move(waiting), asio::error::operation_aborted, SRT_INVALID_SOCK, {});
    }

    bool is_open() const { return !is_closed_; }
    udp::endpoint address() const {
        sockaddr_storage own{};
        int size = sizeof own;
        if (srt_getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size) < 0)
            fail_with_last();
        udp::endpoint endpoint;
        endpoint.resize(std::size_t(size));
        std::memcpy(endpoint.data(), &own, std::size_t(size));
        return endpoint;
    }

private:
    /// Whether the call that waits has ended.
    bool take_guest() {
        sockaddr_storage peer{};
        int size = sizeof peer;
        SRTSOCKET socket = SRT_INVALID_SOCK;
        do
            socket = srt_accept(socket_, reinterpret_cast<sockaddr*>(&peer), &size);
        while (socket == SRT_INVALID_SOCK && srt_getlasterror(nullptr) == SRT_ESCLOSED &&
               srt_getsockstate(socket_) == SRTS_LISTENING);  // the guest has hung up already
        if (socket == SRT_INVALID_SOCK && srt_getlasterror(nullptr) == SRT_EASYNCRCV)
            return false;
        udp::endpoint from;
        if (socket != SRT_INVALID_SOCK) {
            from.resize(std::size_t(size));
            std::memcpy(from.data(), &peer, std::size_t(size));
        }
        finish(std::exchange(waiting_, nullptr),
               socket == SRT_INVALID_SOCK ? asio::error_code(asio::error::no_buffer_space) : asio::error_code(), socket,
               from);
        return true;
    }

    void finish(Accepted accepted, const asio::error_code& error, SRTSOCKET socket, const udp::endpoint& from) {
        std::shared_ptr<SrtLine> line =
            error ? nullptr : std::make_shared<SrtLine>(executor_, socket, unread_by_server_bytes);
        asio::post(executor_, [self = shared_from_this(), accepted = std::move(accepted), error, line, from] {
            accepted(error, line ? std::make_unique<SrtWire>(line, self->context_, std::nullopt) : nullptr, from);
        });
    }

    asio::any_io_executor executor_;
    std::shared_ptr<SrtReactor> reactor_ = SrtReactor::get();
    std::shared_ptr<asio::ssl::context> context_;
    SRTSOCKET socket_;
    bool is_closed_ = false;
    Accepted waiting_;
};

SrtListener::SrtListener(const asio::any_io_executor& executor, const udp::endpoint& address,
                         std::shared_ptr<asio::ssl::context> context, double patience_s, int parity)
    : state_(std::make_shared<State>(executor, address, std::move(context), patience_s, parity)) {}
SrtListener::~SrtListener() {
    state_->close();
}
udp::endpoint SrtListener::address() const {
    return state_->address();
}
void SrtListener::listen() {
    state_->listen();
}
void SrtListener::accept(Accepted accepted) {
    state_->accept(std::move(accepted));
}
void SrtListener::close() {
    state_->close();
}
bool SrtListener::is_open() const {
    return state_->is_open();
}

}  // namespace equistream
