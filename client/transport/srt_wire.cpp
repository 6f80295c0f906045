#include "srt_wire.h"

#include "srt_reactor.h"

#include <equistream/error.h>

#include <asio/error.hpp>
#include <asio/post.hpp>
#include <asio/steady_timer.hpp>

#include <algorithm>
#include <cstring>
#include <optional>
#include <utility>

namespace equistream {

namespace {

using asio::ip::udp;
using Direction = SrtReactor::Direction;

/// What fits into a packet of Ethernet beside SRT's and IPv4's headers. Whoever reads must have room for so many.
constexpr int payload_bytes = 1456;
/// What waits to be sent or to be acknowledged: more would only be older when it comes.
constexpr int send_buffer_bytes = 1 << 20;
constexpr std::chrono::milliseconds between_looks{10};
constexpr int backlog = 64;

bool set(SRTSOCKET socket, SRT_SOCKOPT option, const auto& value) {
    return srt_setsockflag(socket, option, &value, sizeof value) == 0;
}

/// With all options that both ends share.
SRTSOCKET make_socket(const SrtSettings& settings) {
    const SRTSOCKET socket = srt_create_socket();
    const auto patience_ms = int(std::clamp(settings.patience_s * 1000, 100.0, 1e9));
    // No time stamps: what has come is given at once, and what is late is not thrown away.
    const bool good =
        socket != SRT_INVALID_SOCK && set(socket, SRTO_RCVSYN, false) && set(socket, SRTO_SNDSYN, false) &&
        set(socket, SRTO_TSBPDMODE, false) && set(socket, SRTO_TLPKTDROP, false) &&
        set(socket, SRTO_PAYLOADSIZE, payload_bytes) && set(socket, SRTO_SNDBUF, send_buffer_bytes) &&
        set(socket, SRTO_PEERIDLETIMEO, patience_ms) && set(socket, SRTO_CONNTIMEO, patience_ms) &&
        (settings.mbit_s <= 0 || set(socket, SRTO_MAXBW, std::int64_t(settings.mbit_s * 1e6 / 8))) &&
        (settings.secret.empty() ||
         srt_setsockflag(socket, SRTO_PASSPHRASE, settings.secret.data(), int(settings.secret.size())) == 0);
    if (good)
        return socket;
    const std::string reason = srt_getlasterror_str();
    srt_close(socket);
    throw WorkError("SRT: " + reason);
}

udp::endpoint endpoint_of(const sockaddr_storage& address, int size) {
    udp::endpoint endpoint;
    endpoint.resize(std::size_t(size));
    std::memcpy(endpoint.data(), &address, std::size_t(size));
    return endpoint;
}

/// What waits may end after the wire.
class Line : public std::enable_shared_from_this<Line> {
public:
    Line(const asio::any_io_executor& executor, SRTSOCKET socket)
        : executor_(executor), socket_(socket), look_(executor) {}
    ~Line() { close(); }

    void open(const std::optional<udp::endpoint>& server, Wire::Opened opened) {
        if (!server)
            return asio::post(executor_, [opened = std::move(opened)] { opened({}); });
        if (srt_connect(socket_, server->data(), int(server->size())) < 0)
            return asio::post(executor_, [opened = std::move(opened)] { opened(asio::error::connection_refused); });
        wait(Direction::write, [this, opened = std::move(opened)] {
            const bool is_connected = srt_getsockstate(socket_) == SRTS_CONNECTED;
            const int reason = srt_getrejectreason(socket_);
            const bool is_secret = reason == SRT_REJ_BADSECRET || reason == SRT_REJ_UNSECURE;
            opened(is_closed_                  ? asio::error_code(asio::error::operation_aborted)
                   : is_connected              ? asio::error_code()
                   : is_secret                 ? asio::error_code(asio::error::access_denied)
                   : reason == SRT_REJ_TIMEOUT ? asio::error_code(asio::error::timed_out)
                                               : asio::error_code(asio::error::connection_refused));
        });
    }

    void read(std::span<char> bytes, Wire::Moved moved) {
        if (is_closed_)
            return finish(std::move(moved), asio::error::operation_aborted, 0);
        const int count = srt_recvmsg(socket_, bytes.data(), int(bytes.size()));
        if (count > 0)
            return finish(std::move(moved), {}, std::size_t(count));
        if (count < 0 && srt_getlasterror(nullptr) == SRT_EASYNCRCV)
            return wait(Direction::read, [this, bytes, moved = std::move(moved)] { read(bytes, moved); });
        finish(std::move(moved), asio::error::eof, 0);
    }

    void write(std::span<const char> bytes, Wire::Moved moved) {
        if (is_closed_)
            return finish(std::move(moved), asio::error::operation_aborted, 0);
        std::size_t sent = 0;
        while (sent < bytes.size()) {
            const int size = int(std::min<std::size_t>(bytes.size() - sent, payload_bytes));
            const int count = srt_sendmsg(socket_, bytes.data() + sent, size, -1, 1);
            if (count <= 0)
                break;
            sent += std::size_t(count);
        }
        if (sent > 0)
            return finish(std::move(moved), {}, sent);
        if (srt_getlasterror(nullptr) == SRT_EASYNCSND)
            return wait(Direction::write, [this, bytes, moved = std::move(moved)] { write(bytes, moved); });
        finish(std::move(moved), asio::error::connection_reset, 0);
    }

    /// SRT closes both directions at once, and forgets what was not acknowledged yet.
    void end_writing() {
        std::size_t blocks = 0, bytes = 0;
        if (is_closed_ || srt_getsndbuffer(socket_, &blocks, &bytes) < 0 || blocks == 0) {
            srt_close(socket_);
            return;
        }
        look_.expires_after(between_looks);
        look_.async_wait([self = shared_from_this()](const asio::error_code& error) {
            if (!error)
                self->end_writing();
        });
    }

    void close() {
        if (std::exchange(is_closed_, true))
            return;
        look_.cancel();
        reactor_->forget(socket_);
        srt_close(socket_);
        for (auto& waiting : {std::exchange(reads_, nullptr), std::exchange(writes_, nullptr)})
            if (waiting)
                asio::post(executor_, waiting);
    }

private:
    void wait(Direction direction, std::function<void()> ready) {
        auto& mine = direction == Direction::read ? reads_ : writes_;
        mine = [self = shared_from_this(), ready = std::move(ready)] { ready(); };
        reactor_->wait(socket_, direction, executor_, [self = shared_from_this(), direction] {
            auto& waiting = direction == Direction::read ? self->reads_ : self->writes_;
            if (const auto run = std::exchange(waiting, nullptr))
                run();
        });
    }
    void finish(Wire::Moved moved, const asio::error_code& error, std::size_t count) {
        asio::post(executor_,
                   [self = shared_from_this(), moved = std::move(moved), error, count] { moved(error, count); });
    }

    asio::any_io_executor executor_;
    std::shared_ptr<SrtReactor> reactor_ = SrtReactor::get();
    SRTSOCKET socket_;
    asio::steady_timer look_;
    bool is_closed_ = false;
    std::function<void()> reads_, writes_;  // what goes on when it can; each keeps the line
};

class SrtWire : public Wire {
public:
    SrtWire(const asio::any_io_executor& executor, SRTSOCKET socket, const std::optional<udp::endpoint>& server)
        : line_(std::make_shared<Line>(executor, socket)), server_(server) {}
    ~SrtWire() override { line_->close(); }

    void open(Opened opened) override { line_->open(server_, std::move(opened)); }
    void read_some(std::span<char> bytes, Moved moved) override { line_->read(bytes, std::move(moved)); }
    void write_some(std::span<const char> bytes, Moved moved) override { line_->write(bytes, std::move(moved)); }
    void end_writing() override { line_->end_writing(); }
    void close() override { line_->close(); }

private:
    std::shared_ptr<Line> line_;
    std::optional<udp::endpoint> server_;  // nothing: it is connected
};

}  // namespace

std::unique_ptr<Wire> srt_wire(const asio::any_io_executor& executor, const udp::endpoint& server,
                               const SrtSettings& settings) {
    const auto reactor = SrtReactor::get();  // the library is started before a socket is made
    return std::make_unique<SrtWire>(executor, make_socket(settings), server);
}

class SrtListener::State : public std::enable_shared_from_this<State> {
public:
    State(const asio::any_io_executor& executor, const udp::endpoint& address, const SrtSettings& settings)
        : executor_(executor), socket_(make_socket(settings)) {
        if (srt_bind(socket_, address.data(), int(address.size())) >= 0)
            return;
        const std::string reason = srt_getlasterror_str();
        srt_close(socket_);
        throw WorkError(reason);
    }

    void listen() const {
        if (srt_listen(socket_, backlog) < 0)
            throw WorkError(srt_getlasterror_str());
    }

    void accept(Accepted accepted) {
        if (is_closed_)
            return asio::post(
                executor_, [accepted = std::move(accepted)] { accepted(asio::error::operation_aborted, nullptr, {}); });
        sockaddr_storage peer{};
        int size = sizeof peer;
        const SRTSOCKET socket = srt_accept(socket_, reinterpret_cast<sockaddr*>(&peer), &size);
        if (socket == SRT_INVALID_SOCK) {
            waiting_ = std::move(accepted);
            return reactor_->wait(socket_, Direction::read, executor_, [self = shared_from_this()] {
                if (auto waiting = std::exchange(self->waiting_, nullptr))
                    self->accept(std::move(waiting));
            });
        }
        asio::post(executor_,
                   [self = shared_from_this(), accepted = std::move(accepted), socket, from = endpoint_of(peer, size)] {
                       accepted({}, std::make_unique<SrtWire>(self->executor_, socket, std::nullopt), from);
                   });
    }

    void close() {
        if (std::exchange(is_closed_, true))
            return;
        reactor_->forget(socket_);
        srt_close(socket_);
        if (auto waiting = std::exchange(waiting_, nullptr))
            accept(std::move(waiting));
    }

    bool is_open() const { return !is_closed_; }
    udp::endpoint address() const {
        sockaddr_storage own{};
        int size = sizeof own;
        srt_getsockname(socket_, reinterpret_cast<sockaddr*>(&own), &size);
        return endpoint_of(own, size);
    }

private:
    asio::any_io_executor executor_;
    std::shared_ptr<SrtReactor> reactor_ = SrtReactor::get();
    SRTSOCKET socket_;
    bool is_closed_ = false;
    Accepted waiting_;
};

SrtListener::SrtListener(const asio::any_io_executor& executor, const udp::endpoint& address,
                         const SrtSettings& settings)
    : state_(std::make_shared<State>(executor, address, settings)) {}
SrtListener::~SrtListener() {
    state_->close();
}
void SrtListener::listen() {
    state_->listen();
}
udp::endpoint SrtListener::address() const {
    return state_->address();
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
