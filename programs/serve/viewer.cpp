#include "viewer.h"

#include <equistream/text.h>

#include <asio/buffer.hpp>

#include <netinet/tcp.h>

#include <algorithm>
#include <span>

namespace equistream::serve {

namespace {

/// What a viewer may send; more waits in its own system.
constexpr double received_bytes_per_second = 65536;

/// Within the patience. Patience is counted in looks and not on the clock, which goes on where this process was halted
/// itself.
constexpr int looks = 4;

/// What the system keeps for a viewer beyond what is on its way: more would only be older when it comes.
constexpr int max_unsent_bytes = 1 << 17;

}  // namespace

Viewer::Viewer(asio::ip::tcp::socket socket, std::unique_ptr<Feed> feed, double patience_s)
    : socket_(std::move(socket)), due_(socket_.get_executor()), watch_(socket_.get_executor()),
      listening_(socket_.get_executor()), feed_(std::move(feed)), patience_s_(patience_s) {}

void Viewer::start(Gone gone) {
    gone_ = std::move(gone);
    asio::error_code ignored;
    socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
    // Of a machine that has vanished the system would otherwise go on hoping for a quarter of an hour; while there is
    // nothing to send, for two hours.
    const auto patience_ms = unsigned(patience_s_ * 1000);
    const int idle_s = std::clamp(int(patience_s_ / looks), 1, 3600);
    socket_.set_option(asio::socket_base::keep_alive(true), ignored);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_KEEPIDLE, &idle_s, sizeof idle_s);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_KEEPINTVL, &idle_s, sizeof idle_s);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &patience_ms, sizeof patience_ms);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &max_unsent_bytes, sizeof max_unsent_bytes);
    start_ = Clock::now();
    receive();
    watch();
    send_due();
}

void Viewer::stop() {
    is_gone_ = true;
    due_.cancel();
    watch_.cancel();
    listening_.cancel();
    asio::error_code ignored;
    socket_.close(ignored);
    feed_.reset();
}

void Viewer::wake() {
    if (!sends_ && !has_all_ && !is_gone_)
        send_due();
}

void Viewer::send_due() {
    const Portion portion = feed_->next(block_, seconds_since(start_));
    if (!portion.problem.empty())
        return leave("cannot be served further", portion.problem);
    if (portion.ended)
        return finish();
    if (portion.bytes == 0) {
        if (portion.again_s)
            wait_for(*portion.again_s);
        return;
    }
    due_.cancel();
    block_due_s_ = portion.due_s;
    sends_ = true;
    write(0, portion.bytes);
}

void Viewer::wait_for(double time_s) {
    due_.expires_at(start_ + in_clock(time_s));
    due_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        if (!error)
            self->wake();
    });
}

void Viewer::write(std::size_t begin, std::size_t end) {
    socket_.async_write_some(asio::buffer(block_.data() + begin, end - begin),
                             [self = shared_from_this(), begin, end](const asio::error_code& error, std::size_t count) {
                                 if (self->is_gone_)
                                     return;
                                 self->idle_looks_ = 0;
                                 self->bytes_sent_ += std::int64_t(count);
                                 if (error)
                                     return self->leave_with(error);
                                 if (begin + count < end)
                                     return self->write(begin + count, end);
                                 self->sends_ = false;
                                 self->send_due();
                             });
}

void Viewer::watch() {
    watch_.expires_after(in_clock(patience_s_ / looks));
    watch_.async_wait([self = shared_from_this()](const asio::error_code& error) {
        if (error || self->is_gone_)
            return;
        const bool waits_for_it = self->sends_ || self->has_all_;
        const bool late = self->sends_ && seconds_since(self->start_) - self->block_due_s_ > self->patience_s_;
        self->idle_looks_ = waits_for_it ? self->idle_looks_ + 1 : 0;
        self->late_looks_ = late ? self->late_looks_ + 1 : 0;
        if (self->idle_looks_ > looks)
            return self->drop_idle();
        if (self->late_looks_ > looks)
            return self->leave("dropped", formatted("stayed more than %g s behind", self->patience_s_));
        self->watch();
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
                                self->feed_->hear(std::span(self->received_).first(count));
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
    idle_looks_ = 0;
    if (has_ended_)
        return leave("has all");
    asio::error_code ignored;
    socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
}

void Viewer::leave_with(const asio::error_code& error) {
    if (error == asio::error::timed_out)
        drop_idle();
    else
        leave(has_all_ ? "has all" : "left");
}

void Viewer::drop_idle() {
    if (has_all_)
        leave("dropped", formatted("did not hang up for %g s after the end", patience_s_));
    else
        leave("dropped", formatted("did not read for %g s", patience_s_));
}

void Viewer::leave(const std::string& how, const std::string& detail) {
    stop();
    gone_(how, detail);
}

}  // namespace equistream::serve
