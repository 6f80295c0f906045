#include "srt_line.h"

#include <equistream/error.h>

#include <asio/error.hpp>
#include <asio/post.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

namespace equistream {

namespace {

using Direction = SrtReactor::Direction;

/// Between two looks at what has been acknowledged.
constexpr std::chrono::milliseconds between_looks{5};
/// Between two questions whether there is more to read, for so long after there was.
constexpr std::chrono::milliseconds between_questions{2}, asked_for{200};
/// Packets are spread over a quarter of the time to their acknowledgement.
constexpr double bursts = 4;
/// So many packets may overtake one on a line where that is seen to happen, before it is asked for again.
constexpr int most_overtaking = 40;
/// Each ten packets are followed by what makes up for any one of them. It costs 10 % more bytes: at 5 % of loss
/// spheres come 35 ms late instead of 65. What it cannot make up for is asked for at once.
constexpr std::string_view correction = "fec,cols:10,arq:always";
/// What is lost is asked for when something later comes. Where nothing was to be sent for a while, this is; it is
/// nobody's data, which never comes as one byte.
constexpr char filler = 0;
constexpr double fills_after_s = 0.02;

bool set(SRTSOCKET socket, SRT_SOCKOPT option, const auto& value) {
    return srt_setsockflag(socket, option, &value, sizeof value) == 0;
}

}  // namespace

SRTSOCKET make_srt_socket(double patience_s, int unread_bytes) {
    const SRTSOCKET socket = srt_create_socket();
    const auto patience_ms = int(std::clamp(patience_s * 1000, 100.0, 1e9));
    // No time stamps: what has come is given at once, and what is late is not thrown away.
    if (socket != SRT_INVALID_SOCK && set(socket, SRTO_RCVSYN, false) && set(socket, SRTO_SNDSYN, false) &&
        set(socket, SRTO_TSBPDMODE, false) && set(socket, SRTO_TLPKTDROP, false) &&
        set(socket, SRTO_LOSSMAXTTL, most_overtaking) && set(socket, SRTO_PAYLOADSIZE, int(srt_payload_bytes)) &&
        set(socket, SRTO_RCVBUF, unread_bytes) && set(socket, SRTO_PEERIDLETIMEO, patience_ms) &&
        set(socket, SRTO_CONNTIMEO, patience_ms) &&
        srt_setsockflag(socket, SRTO_PACKETFILTER, correction.data(), int(correction.size())) == 0)
        return socket;
    const std::string reason = srt_getlasterror_str();
    srt_close(socket);
    throw WorkError("SRT: " + reason);
}

SrtLine::SrtLine(const asio::any_io_executor& executor, SRTSOCKET socket)
    : executor_(executor), socket_(socket), look_(executor), ask_(executor) {}

void SrtLine::connect(const asio::ip::udp::endpoint& server, Wire::Opened connected) {
    // Who waits does so before there is anything to wait for: a refusal may come at once.
    wait(Direction::write, [this, connected = std::move(connected)] {
        const int reason = srt_getrejectreason(socket_);
        connected(is_closed_                                    ? asio::error::operation_aborted
                  : srt_getsockstate(socket_) == SRTS_CONNECTED ? asio::error_code()
                  : reason == SRT_REJ_TIMEOUT                   ? asio::error::timed_out
                                                                : asio::error::connection_refused);
    });
    if (srt_connect(socket_, server.data(), int(server.size())) >= 0)
        return;
    reactor_->forget(socket_);
    asio::post(executor_, [self = shared_from_this()] { run(self->writes_); });
}

void SrtLine::read(std::span<char> bytes, Wire::Moved moved) {
    if (is_closed_)
        return finish(std::move(moved), asio::error::operation_aborted, 0);
    std::size_t count = take_kept(bytes);
    int got = 0;
    while (bytes.size() - count >= srt_payload_bytes && (got = receive(bytes.subspan(count))) > 0)
        count += std::size_t(got);
    if (count == 0 && !bytes.empty() && bytes.size() < srt_payload_bytes) {
        kept_.resize(srt_payload_bytes);
        got = receive(kept_);
        kept_.resize(std::size_t(std::max(got, 0)));
        kept_begin_ = 0;
        count = take_kept(bytes);
    }
    if (count > 0 || bytes.empty()) {
        received_ = Clock::now();
        return finish(std::move(moved), {}, count);
    }
    if (got >= 0 || srt_getlasterror(nullptr) != SRT_EASYNCRCV)
        return finish(std::move(moved), asio::error::eof, 0);
    wait(Direction::read, [this, bytes, moved = std::move(moved)] { read(bytes, moved); });
    ask_again();
}

/// SRT says that there is something to read with its next acknowledgement, which is up to 10 ms later. While much comes
/// it is asked meanwhile.
void SrtLine::ask_again() {
    if (asks_ || Clock::now() - received_ > asked_for)
        return;
    asks_ = true;
    ask_.expires_after(between_questions);
    ask_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        self->asks_ = false;
        if (!error && !self->is_closed_)
            run(self->reads_);
    });
}

/// A packet's bytes, as srt_recvmsg gives them.
int SrtLine::receive(std::span<char> into) const {
    int got = 0;
    do
        got = srt_recvmsg(socket_, into.data(), int(into.size()));
    while (got == 1);
    return got;
}

std::size_t SrtLine::take_kept(std::span<char> bytes) {
    const std::size_t count = std::min(bytes.size(), kept_.size() - kept_begin_);
    std::copy_n(kept_.begin() + std::ptrdiff_t(kept_begin_), count, bytes.begin());
    kept_begin_ += count;
    return count;
}

void SrtLine::write(std::span<const char> bytes, Wire::Moved moved) {
    if (is_closed_)
        return finish(std::move(moved), asio::error::operation_aborted, 0);
    const std::size_t window = window_.bytes(), most = window - std::min(window, unacknowledged());
    std::size_t sent = 0;
    int count = 0;
    while (sent < bytes.size() && sent < most) {
        auto size = std::min(bytes.size() - sent, srt_payload_bytes);
        size -= bytes.size() - sent - size == 1 ? 1 : 0;  // one byte alone would be taken for the filler
        count = srt_sendmsg(socket_, bytes.data() + sent, int(size), -1, 1);
        if (count <= 0)
            break;
        sent += std::size_t(count);
    }
    if (sent > 0 || bytes.empty()) {
        written_bytes_ += sent;
        wrote_ = Clock::now();
        keep_looking();
        return finish(std::move(moved), {}, sent);
    }
    if (count < 0 && srt_getlasterror(nullptr) != SRT_EASYNCSND)
        return finish(std::move(moved), asio::error::connection_reset, 0);
    writes_.push_back([self = shared_from_this(), bytes, moved = std::move(moved)] { self->write(bytes, moved); });
    keep_looking();
}

std::size_t SrtLine::unacknowledged() const {
    std::size_t packets = 0, bytes = 0;
    return srt_getsndbuffer(socket_, &packets, &bytes) < 0 ? 0 : bytes;  // failed: the next write will say so
}

/// While something waits to be written or acknowledged.
void SrtLine::keep_looking() {
    if (std::exchange(looks_, true))
        return;
    look_.expires_after(between_looks);
    look_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        self->looks_ = false;
        if (!error && !self->is_closed_)
            self->look();
    });
}

void SrtLine::look() {
    const std::size_t on_their_way = unacknowledged();
    const auto now = Clock::now();
    const auto seconds = [](auto duration) { return std::chrono::duration<double>(duration).count(); };
    window_.add(seconds(now - start_), double(written_bytes_), double(written_bytes_ - on_their_way));
    set(socket_, SRTO_MAXBW, std::int64_t(bursts * double(window_.bytes()) / window_.acknowledged_after_s()));
    if (on_their_way > 0 && seconds(now - wrote_) > window_.acknowledged_after_s() + fills_after_s) {
        written_bytes_ += srt_sendmsg(socket_, &filler, 1, -1, 1) == 1 ? 1 : 0;
        wrote_ = now;
    }
    run(writes_);
    if (on_their_way > 0 || !writes_.empty())
        keep_looking();
}

void SrtLine::close() {
    if (std::exchange(is_closed_, true))
        return;
    look_.cancel();
    ask_.cancel();
    reactor_->forget(socket_);
    srt_close(socket_);
    for (auto* all : {&reads_, &writes_})
        for (auto& waiting : std::exchange(*all, {}))
            asio::post(executor_, std::move(waiting));
}

void SrtLine::wait(Direction direction, std::function<void()> ready) {
    (direction == Direction::read ? reads_ : writes_).push_back([self = shared_from_this(), ready = std::move(ready)] {
        ready();
    });
    reactor_->wait(socket_, direction, executor_, [self = shared_from_this(), direction] {
        run(direction == Direction::read ? self->reads_ : self->writes_);
    });
}

void SrtLine::run(std::vector<std::function<void()>>& waiting) {
    for (const auto& go_on : std::exchange(waiting, {}))
        go_on();
}

void SrtLine::finish(Wire::Moved moved, const asio::error_code& error, std::size_t count) {
    asio::post(executor_, [self = shared_from_this(), moved = std::move(moved), error, count] { moved(error, count); });
}

}  // namespace equistream
