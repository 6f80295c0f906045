#include "turned_away.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

namespace equistream::serve {

TurnedAway::TurnedAway(const asio::any_io_executor& executor, std::size_t max_held)
    : max_held_(max_held), timer_(executor) {}

void TurnedAway::add(std::unique_ptr<Wire> wire) {
    if (held_.size() >= max_held_)
        return;
    held_.push_back({Clock::now() + held_for, std::move(wire)});
    if (held_.size() == 1)
        wait();
}

void TurnedAway::clear() {
    timer_.cancel();
    held_.clear();
}

void TurnedAway::wait() {
    timer_.expires_at(held_.front().until);
    timer_.async_wait([this](const asio::error_code& cancelled) {
        if (cancelled)
            return;
        const Clock::time_point now = Clock::now();
        while (!held_.empty() && held_.front().until <= now)
            held_.pop_front();
        if (!held_.empty())
            wait();
    });
}

std::size_t max_turned_away() {
    constexpr rlim_t max_held = 512;
    rlimit files{};
    return getrlimit(RLIMIT_NOFILE, &files) == 0 ? std::size_t(std::min(max_held, files.rlim_cur / 2)) : 0;
}

}  // namespace equistream::serve
