#include "viewer.h"

#include <equistream/text.h>

#include <asio/error.hpp>

#include <span>
#include <utility>

namespace equistream::serve {

namespace {

/// Within the patience. Patience is counted in looks and not on the clock, which goes on where this process was halted
/// itself.
constexpr int looks = 4;

}  // namespace

Viewer::Viewer(const asio::any_io_executor& executor, std::unique_ptr<Wire> wire, std::unique_ptr<Feed> feed,
               double patience_s)
    : wire_(std::move(wire)), due_(executor), watch_(executor), listening_(executor), feed_(std::move(feed)),
      patience_s_(patience_s) {}

void Viewer::start(Gone gone) {
    gone_ = std::move(gone);
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
    wire_->close();
    feed_.reset();
}

void Viewer::wake() {
    if (!sends_ && !has_all_ && !is_gone_)
        send_due();
}

void Viewer::send_due() {
    const double elapsed_s = seconds_since(start_);
    const Unacknowledged line = wire_->unacknowledged();
    if (line.bytes < std::exchange(unacknowledged_, line.bytes))
        idle_looks_ = 0;
    feed_->see_line(elapsed_s, line);
    const Portion portion = feed_->next(block_, elapsed_s);
    if (!portion.problem.empty())
        return leave(not_served, portion.problem);
    is_held_ = portion.held;
    if (portion.ended)
        return finish();
    if (is_held_)
        block_due_s_ = portion.due_s;
    if (portion.bytes == 0) {
        if (portion.again_s)
            wait_for(*portion.again_s);
        return;
    }
    due_.cancel();
    block_due_s_ = portion.due_s;
    sends_ = true;
    idle_looks_ = 0;
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
    wire_->write_some(std::span(block_).subspan(begin, end - begin),
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
        // Who has said all and got nothing may have gone: TCP tells that only once something is sent.
        const bool may_have_gone = self->has_ended_ && self->bytes_sent_ == 0 && !self->sends_;
        const bool sends = self->sends_ || self->is_held_;
        const bool waits_for_it = sends || self->has_all_ || may_have_gone;
        const bool late = sends && seconds_since(self->start_) - self->block_due_s_ > self->patience_s_;
        self->idle_looks_ = waits_for_it ? self->idle_looks_ + 1 : 0;
        self->late_looks_ = late ? self->late_looks_ + 1 : 0;
        if (self->idle_looks_ > looks)
            return may_have_gone ? self->leave("left") : self->drop_idle();
        if (self->late_looks_ > looks)
            return self->leave("dropped", formatted("stayed more than %g s behind", self->patience_s_));
        self->watch();
    });
}

void Viewer::receive() {
    wire_->read_some(received_, [self = shared_from_this()](const asio::error_code& error, std::size_t count) {
        if (self->is_gone_)
            return;
        if (error && error != asio::error::eof)
            return self->leave_with(error);
        if (error) {  // whoever has said all may still be listening
            self->has_ended_ = true;
            if (self->has_all_)
                self->leave(self->all_text());
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
        return leave(all_text());
    wire_->end_writing();
}

void Viewer::leave_with(const asio::error_code& error) {
    if (error == asio::error::timed_out)
        drop_idle();
    else
        leave(has_all_ ? all_text() : "left");
}

/// A scene whose server ends before its first sphere has nothing to send.
std::string Viewer::all_text() const {
    return bytes_sent_ > 0 ? "has all" : "got nothing";
}

void Viewer::drop_idle() {
    if (has_all_)
        leave("dropped", formatted("did not disconnect for %g s after the end", patience_s_));
    else
        leave("dropped", formatted("did not read for %g s", patience_s_));
}

void Viewer::leave(const std::string& how, const std::string& detail) {
    stop();
    gone_(how, detail);
}

}  // namespace equistream::serve
