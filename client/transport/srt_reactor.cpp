#include "srt_reactor.h"

#include <equistream/error.h>

#include <asio/execution/outstanding_work.hpp>
#include <asio/post.hpp>
#include <asio/prefer.hpp>

#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <string>
#include <utility>

namespace equistream {

namespace {

constexpr int max_at_once = 64;
constexpr std::chrono::milliseconds between_failures{10};

}  // namespace

std::shared_ptr<SrtReactor> SrtReactor::get() {
    static std::mutex mutex;
    static std::weak_ptr<SrtReactor> shared;
    const std::lock_guard lock(mutex);
    auto reactor = shared.lock();
    if (!reactor) {
        reactor.reset(new SrtReactor);
        shared = reactor;
    }
    return reactor;
}

SrtReactor::SrtReactor() {
    if (srt_startup() < 0)
        throw WorkError(std::string("SRT cannot be started: ") + srt_getlasterror_str());
    // Programs say what went wrong themselves, in a line each. It is the whole process's log.
    srt_setloghandler(nullptr, [](void*, int, const char*, int, const char*, const char*) {});
    epoll_ = srt_epoll_create();
    wake_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    const int reading = SRT_EPOLL_IN;
    if (epoll_ < 0 || wake_ < 0 || srt_epoll_add_ssock(epoll_, wake_, &reading) < 0) {
        if (wake_ >= 0)
            close(wake_);
        srt_cleanup();
        throw WorkError("SRT has no room for another poll");
    }
    thread_ = std::thread([this] { run(); });
}

SrtReactor::~SrtReactor() {
    {
        const std::lock_guard lock(mutex_);
        has_ended_ = true;
    }
    eventfd_write(wake_, 1);
    thread_.join();
    srt_epoll_release(epoll_);
    close(wake_);
    srt_cleanup();
}

void SrtReactor::wait(SRTSOCKET socket, Direction direction, const asio::any_io_executor& executor,
                      std::function<void()> ready) {
    const std::lock_guard lock(mutex_);
    const bool is_new = !watched_.contains(socket);
    Watched& watched = watched_[socket];
    (direction == Direction::read ? watched.read : watched.write) = {
        asio::prefer(executor, asio::execution::outstanding_work.tracked), std::move(ready)};
    // SRT says nothing of what was over before it was watched: whoever asks again is told.
    if (watch(socket, watched, is_new) && srt_getsockstate(socket) < SRTS_BROKEN)
        return;
    srt_epoll_remove_usock(epoll_, socket);
    for (Waiting* waiting : {&watched.read, &watched.write})
        if (waiting->ready)
            asio::post(waiting->executor, std::exchange(waiting->ready, nullptr));
    watched_.erase(socket);
}

void SrtReactor::forget(SRTSOCKET socket) {
    const std::lock_guard lock(mutex_);
    if (watched_.erase(socket) > 0)
        srt_epoll_remove_usock(epoll_, socket);
}

bool SrtReactor::watch(SRTSOCKET socket, const Watched& watched, bool is_new) const {
    int events = SRT_EPOLL_ERR;
    if (watched.read.ready)
        events |= SRT_EPOLL_IN;
    if (watched.write.ready)
        events |= SRT_EPOLL_OUT;
    return (is_new ? srt_epoll_add_usock(epoll_, socket, &events) : srt_epoll_update_usock(epoll_, socket, &events)) >=
           0;
}

void SrtReactor::tell(SRTSOCKET socket, Direction direction) {
    const auto found = watched_.find(socket);
    if (found == watched_.end())
        return;
    Waiting& waiting = direction == Direction::read ? found->second.read : found->second.write;
    if (!waiting.ready)
        return;
    asio::post(waiting.executor, std::exchange(waiting.ready, nullptr));
    waiting.executor = {};
    if (found->second.read.ready || found->second.write.ready) {
        watch(socket, found->second, false);
        return;
    }
    // A socket without events would still be reported for its errors.
    srt_epoll_remove_usock(epoll_, socket);
    watched_.erase(found);
}

void SrtReactor::run() {
    for (;;) {
        std::array<SRTSOCKET, max_at_once> readable{}, writable{};
        std::array<SYSSOCKET, 1> woken{};
        int reads = max_at_once, writes = max_at_once, wakes = 1;
        if (srt_epoll_wait(epoll_, readable.data(), &reads, writable.data(), &writes, -1, woken.data(), &wakes, nullptr,
                           nullptr) < 0) {
            reads = writes = 0;
            std::this_thread::sleep_for(between_failures);
        }
        const std::lock_guard lock(mutex_);
        if (has_ended_)
            return;
        for (int i = 0; i < reads && i < max_at_once; ++i)
            tell(readable[std::size_t(i)], Direction::read);
        for (int i = 0; i < writes && i < max_at_once; ++i)
            tell(writable[std::size_t(i)], Direction::write);
    }
}

}  // namespace equistream
