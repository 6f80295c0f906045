#pragma once
/// When SRT sockets can be read or written, told to the io_contexts of those who wait. One thread for the process.
#include <asio/any_io_executor.hpp>

#include <srt/srt.h>

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

namespace equistream {

class SrtReactor {
public:
    /// The library is started with the first, and cleaned up with the last one. Throws WorkError where it cannot be.
    static std::shared_ptr<SrtReactor> get();
    ~SrtReactor();
    SrtReactor(const SrtReactor&) = delete;
    SrtReactor& operator=(const SrtReactor&) = delete;

    enum class Direction { read, write };
    /// `ready` is posted to the executor once it can be, or has failed. One waits for each direction of a socket, and
    /// is the io_context's work meanwhile.
    void wait(SRTSOCKET socket, Direction direction, const asio::any_io_executor& executor,
              std::function<void()> ready);
    /// Nobody waits for it any more; what was posted still comes.
    void forget(SRTSOCKET socket);

private:
    struct Waiting {
        asio::any_io_executor executor;
        std::function<void()> ready;  // empty: nobody waits
    };
    struct Watched {
        Waiting read, write;
    };

    SrtReactor();
    void run();
    void tell(SRTSOCKET socket, Direction direction);
    bool watch(SRTSOCKET socket, const Watched& watched, bool is_new) const;

    int epoll_ = -1, wake_ = -1;
    bool has_ended_ = false;
    std::mutex mutex_;
    std::map<SRTSOCKET, Watched> watched_;
    std::thread thread_;
};

}  // namespace equistream
