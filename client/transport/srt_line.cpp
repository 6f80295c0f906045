#include "srt_line.h"

#include <equistream/error.h>

#include <asio/error.hpp>
#include <asio/post.hpp>

#include <algorithm>
#include <cassert>
#include <string>

namespace equistream {

namespace {

using Direction = SrtReactor::Direction;

/// Between two looks at what has been acknowledged.
constexpr std::chrono::milliseconds between_looks{5};
/// Between two looks whether there is more to read, for so long after there was.
constexpr std::chrono::milliseconds between_polls{2}, polled_for{200};
/// Packets are spread over a quarter of the time to their acknowledgement.
constexpr double pacing_gain = 4;
/// So many packets may overtake one on a line where that is seen to happen, before it is asked for again.
constexpr int reorder_tolerance = 40;
/// What is lost is asked for when something later comes. Where nothing was to be sent for a while, this is; it is
/// nobody's data, which never comes as one byte.
constexpr char filler = 0;
constexpr double fills_after_s = 0.02;

bool set(SRTSOCKET socket, SRT_SOCKOPT option, const auto& value) {
    return srt_setsockflag(socket, option, &value, sizeof value) == 0;
}

}  // namespace

SRTSOCKET make_srt_socket(double patience_s, double connect_s, int parity) {
    const SRTSOCKET socket = srt_create_socket();
    // Twice: whoever waits gives up first, and says why. Beyond 2,147 s libsrt's own arithmetic overflows.
    const auto idle_ms = int(std::clamp(2000 * patience_s, 100.0, 2e6));
    const auto connect_ms = int(std::clamp(1000 * connect_s, 100.0, 2e6));
    // What parity cannot repair is asked for at once.
    const std::string n = std::to_string(parity), error_correction = "fec,cols:" + n + ",rows:" + n + ",arq:always";
    // No time stamps: what has come is given at once, and what is late is not thrown away.
    if (socket != SRT_INVALID_SOCK && set(socket, SRTO_RCVSYN, false) && set(socket, SRTO_SNDSYN, false) &&
        set(socket, SRTO_TSBPDMODE, false) && set(socket, SRTO_TLPKTDROP, false) &&
        set(socket, SRTO_LOSSMAXTTL, reorder_tolerance) && set(socket, SRTO_PAYLOADSIZE, int(srt_payload_bytes)) &&
        set(socket, SRTO_PEERIDLETIMEO, idle_ms) && set(socket, SRTO_CONNTIMEO, connect_ms) &&
        srt_setsockflag(socket, SRTO_PACKETFILTER, error_correction.data(), int(error_correction.size())) == 0)
        return socket;
    const std::string reason = srt_getlasterror_str();
    srt_close(socket);
    throw WorkError("SRT: " + reason);
}

SrtLine::SrtLine(const asio::any_io_executor& executor, SRTSOCKET socket, std::size_t max_unread_bytes)
    : executor_(executor), socket_(socket), max_unread_bytes_(max_unread_bytes), poll_(executor), look_(executor) {}

void SrtLine::connect(const asio::ip::udp::endpoint& server, Wire::Opened connected) {
    writes_.push_back([self = shared_from_this(), connected = std::move(connected)] {
        const int reason = srt_getrejectreason(self->socket_);
        connected(self->is_closed_                                    ? asio::error::operation_aborted
                  : srt_getsockstate(self->socket_) == SRTS_CONNECTED ? asio::error_code()
                  : reason == SRT_REJ_TIMEOUT                         ? asio::error::timed_out
                  : reason == SRT_REJ_FILTER                          ? other_parity
                                                                      : asio::error::connection_refused);
    });
    // Waited for before there is anything to wait for: a refusal may come at once.
    reactor_->wait(socket_, Direction::write, executor_, [self = shared_from_this()] { self->run_writes(); });
    if (srt_connect(socket_, server.data(), int(server.size())) >= 0)
        return;
    reactor_->forget(socket_);
    asio::post(executor_, [self = shared_from_this()] { self->run_writes(); });
}

void SrtLine::read(std::span<char> bytes, Wire::Moved moved) {
    if (is_closed_)
        return finish(std::move(moved), asio::error::operation_aborted, 0);
    reads_.push_back({bytes, std::move(moved)});
    if (!std::exchange(drains_, true))
        drain();
    serve_reads();
}

/// Takes what has come, whether it is asked for yet or not: SRT never repeats what found its buffer full.
void SrtLine::drain() {
    if (is_closed_ || has_ended_)
        return;
    int got = 0;
    do {
        const std::size_t size = unread_.size();
        unread_.resize(size + srt_payload_bytes);
        got = srt_recvmsg(socket_, unread_.data() + size, int(srt_payload_bytes));
        unread_.resize(size + std::size_t(got > 1 ? got : 0));  // one byte is the filler
        received_ = got > 0 ? Clock::now() : received_;
    } while (got > 0 && unread_.size() - unread_begin_ <= max_unread_bytes_);
    const bool more_may_come = got < 0 && srt_getlasterror(nullptr) == SRT_EASYNCRCV;
    if (!more_may_come) {
        has_ended_ = true;
        reactor_->forget(socket_);
        srt_close(socket_);
    }
    serve_reads();
    if (has_ended_)
        return;
    reactor_->wait(socket_, Direction::read, executor_, [self = shared_from_this()] { self->drain(); });
    drain_soon();
}

/// SRT says that there is something to read with its next acknowledgement, which is up to 10 ms later. While much comes
/// it is asked meanwhile.
void SrtLine::drain_soon() {
    if (polls_ || Clock::now() - received_ > polled_for)
        return;
    polls_ = true;
    poll_.expires_after(between_polls);
    poll_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        self->polls_ = false;
        if (!error)
            self->drain();
    });
}

void SrtLine::serve_reads() {
    while (!reads_.empty()) {
        const std::size_t count = std::min(reads_.front().bytes.size(), unread_.size() - unread_begin_);
        if (count == 0 && !has_ended_ && !reads_.front().bytes.empty())
            break;
        std::copy_n(unread_.begin() + std::ptrdiff_t(unread_begin_), count, reads_.front().bytes.begin());
        unread_begin_ += count;
        const bool is_end = count == 0 && !reads_.front().bytes.empty();
        finish(std::move(reads_.front().moved), is_end ? asio::error_code(asio::error::eof) : asio::error_code(),
               count);
        reads_.pop_front();
    }
    if (2 * unread_begin_ >= unread_.size()) {
        unread_.erase(unread_.begin(), unread_.begin() + std::ptrdiff_t(unread_begin_));
        unread_begin_ = 0;
    }
}

void SrtLine::write(std::span<const char> bytes, Wire::Moved moved) {
    if (is_closed_)
        return finish(std::move(moved), asio::error::operation_aborted, 0);
    assert(bytes.size() != 1);  // it would be taken for the filler
    const std::size_t window = window_.bytes(), most = window - std::min(window, unacknowledged_bytes());
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
        return finish(std::move(moved), asio::error::eof, 0);
    has_waited_ = true;
    writes_.push_back([self = shared_from_this(), bytes, moved = std::move(moved)] { self->write(bytes, moved); });
    keep_looking();
}

std::size_t SrtLine::unacknowledged_bytes() const {
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
    const std::size_t on_their_way = unacknowledged_bytes();
    const auto now = Clock::now();
    const auto seconds = [](auto duration) { return std::chrono::duration<double>(duration).count(); };
    window_.add(seconds(now - start_), double(written_bytes_),
                double(written_bytes_ - std::min<std::uint64_t>(written_bytes_, on_their_way)),
                std::exchange(has_waited_, !writes_.empty()));
    set(socket_, SRTO_MAXBW, std::int64_t(pacing_gain * double(window_.bytes()) / window_.acknowledged_after_s()));
    if (on_their_way > 0 && seconds(now - wrote_) > window_.acknowledged_after_s() + fills_after_s) {
        written_bytes_ += srt_sendmsg(socket_, &filler, 1, -1, 1) == 1 ? 1 : 0;
        wrote_ = now;
    }
    run_writes();
    if (on_their_way > 0 || !writes_.empty())
        keep_looking();
}

void SrtLine::close() {
    if (std::exchange(is_closed_, true))
        return;
    look_.cancel();
    poll_.cancel();
    reactor_->forget(socket_);
    srt_close(socket_);
    for (auto& read : std::exchange(reads_, {}))
        finish(std::move(read.moved), asio::error::operation_aborted, 0);
    for (auto& go_on : std::exchange(writes_, {}))
        asio::post(executor_, std::move(go_on));
}

void SrtLine::run_writes() {
    for (const auto& go_on : std::exchange(writes_, {}))
        go_on();
}

void SrtLine::finish(Wire::Moved moved, const asio::error_code& error, std::size_t count) {
    asio::post(executor_, [moved = std::move(moved), error, count] { moved(error, count); });
}

}  // namespace equistream
