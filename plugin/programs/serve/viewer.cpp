#include "viewer.h"

#include <equistream/formatted.h>

#include <asio/buffer.hpp>

#include <netinet/tcp.h>

#include <algorithm>

namespace equistream::serve {

namespace {

using Clock = std::chrono::steady_clock;

/// What a viewer may send; more waits in its own system.
constexpr double received_bytes_per_second = 65536;

Clock::duration in_clock(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
}

}  // namespace

Viewer::Viewer(asio::ip::tcp::socket socket, const Recording& recording, const ViewerSettings& settings)
    : socket_(std::move(socket)), due_(socket_.get_executor()), patience_(socket_.get_executor()),
      listening_(socket_.get_executor()), recording_(recording), settings_(settings) {}

void Viewer::start(Gone gone) {
    gone_ = std::move(gone);
    asio::error_code ignored;
    socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
    // Of a machine that has vanished the system would otherwise go on hoping for a quarter of an hour.
    const auto patience_ms = unsigned(settings_.patience_s * 1000);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof patience_ms);
    start_ = Clock::now();
    receive();
    send_due();
}

void Viewer::stop() {
    is_gone_ = true;
    due_.cancel();
    patience_.cancel();
    listening_.cancel();
    asio::error_code ignored;
    socket_.close(ignored);
}

double Viewer::elapsed_s() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
}

void Viewer::send_due() {
    if (position_ == recording_.bytes()) {
        if (!settings_.loop)
            return finish();
        position_ = 0;
        round_start_s_ += recording_.duration_s();
    }
    const std::int64_t due = recording_.due_at(elapsed_s() - round_start_s_);
    if (due <= position_)
        return wait_for(round_start_s_ + recording_.time_of(position_));
    const auto wanted = std::min(std::size_t(due - position_), block_.size());
    const std::size_t count = recording_.read(position_, std::span(block_).first(wanted));
    if (count == 0)
        return leave("cannot be served further", "the file has become shorter or cannot be read");
    position_ += std::int64_t(count);
    write(0, count);
}

void Viewer::wait_for(double time_s) {
    due_.expires_at(start_ + in_clock(time_s));
    due_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        if (!error && !self->is_gone_)
            self->send_due();
    });
}

void Viewer::write(std::size_t begin, std::size_t end) {
    be_patient();
    socket_.async_write_some(asio::buffer(block_.data() + begin, end - begin),
                             [self = shared_from_this(), begin, end](const asio::error_code& error, std::size_t count) {
                                 if (self->is_gone_)
                                     return;
                                 // Not only cancelled: a wait that is over already sees that it is not meant.
                                 self->patience_.expires_at(Clock::time_point::max());
                                 self->bytes_sent_ += std::int64_t(count);
                                 if (error)
                                     self->leave_with(error);
                                 else if (begin + count < end)
                                     self->write(begin + count, end);
                                 else
                                     self->send_due();
                             });
}

void Viewer::be_patient() {
    patience_.expires_after(in_clock(settings_.patience_s));
    patience_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        if (error || self->is_gone_ || self->patience_.expiry() > Clock::now())
            return;
        self->drop();
    });
}

void Viewer::receive() {
    socket_.async_read_some(asio::buffer(received_),
                            [self = shared_from_this()](const asio::error_code& error, std::size_t count) {
                                if (self->is_gone_)
                                    return;
                                if (error && error != asio::error::eof)
                                    return self->leave_with(error);
                                if (error) {  // whoever has said all may still be listening
                                    self->has_ended_ = true;
                                    if (self->has_all_)
                                        self->leave("has all");
                                    return;
                                }
                                self->listening_.expires_after(in_clock(double(count) / received_bytes_per_second));
                                self->listening_.async_wait([self](const asio::error_code& cancelled) {
                                    if (!cancelled && !self->is_gone_)
                                        self->receive();
                                });
                            });
}

/// Closing while something the viewer sent is unread would take back what it has not read yet: it goes first.
void Viewer::finish() {
    has_all_ = true;
    if (has_ended_)
        return leave("has all");
    asio::error_code ignored;
    socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
    be_patient();
}

void Viewer::leave_with(const asio::error_code& error) {
    if (error == asio::error::timed_out)
        drop();
    else
        leave(has_all_ ? "has all" : "left");
}

void Viewer::drop() {
    if (has_all_)
        leave("dropped", formatted("did not hang up for %g s after the end", settings_.patience_s));
    else
        leave("dropped", formatted("did not read for %g s", settings_.patience_s));
}

void Viewer::leave(const std::string& how, const std::string& detail) {
    stop();
    gone_(how, detail);
}

}  // namespace equistream::serve
