#pragma once
/// A server on this machine that sends a coded stream picture by picture, as far as it is told to.
#include <equistream/elapsed.h>
#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iterator>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace equistream::test {

/// So many pictures, 30 a second, in as many parts, which are of one size.
inline std::vector<std::vector<char>> coded(int pictures) {
    const std::filesystem::path file =
        std::filesystem::temp_directory_path() / ("equistream_paced_" + std::to_string(::getpid()) + ".mkv");
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.gop = 6;
    settings.tracks = {{TrackRole::main, 128, 64}};
    settings.pictures = std::uint32_t(pictures);
    StreamWriter writer(file.string(), settings);
    std::vector<std::int64_t> ends;
    for (int index = 0; index < pictures; ++index) {
        FrameInfo info;
        info.index = index;
        info.time_s = index / 30.0;
        info.camera = EquirectCamera{128, 64, {}};
        ByteImage rgb(128, 64, 3);
        for (std::size_t i = 0; i < rgb.samples().size(); ++i)
            rgb.samples()[i] = std::uint8_t((i * 7 + i / 384 * 31 + std::size_t(index) * 11) % 251);
        writer.write(TrackRole::main, rgb.view(), info);
    }
    writer.finish();
    std::ifstream in(file, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(in), {}};
    std::filesystem::remove(file);
    std::vector<std::vector<char>> parts;
    for (int i = 0; i < pictures; ++i) {
        const auto at = [&](int part) { return bytes.begin() + std::ptrdiff_t(bytes.size()) * part / pictures; };
        parts.emplace_back(at(i), at(i + 1));
    }
    return parts;
}

/// Serves one viewer at a time, by a thread of its own, which waits for one before it sends.
class PacedServer {
public:
    PacedServer() {
        listen();
        thread_ = std::thread([this] { run(); });
    }
    ~PacedServer() {
        {
            const std::lock_guard lock(mutex_);
            stopping_ = true;
        }
        changed_.notify_all();
        thread_.join();
        hang_up();
    }
    PacedServer(const PacedServer&) = delete;
    PacedServer& operator=(const PacedServer&) = delete;

    std::string address() const { return "tcp://127.0.0.1:" + std::to_string(ntohs(address_.sin_port)); }

    /// Sends these parts, one every thirtieth of a second. One that hung up is there again.
    void give(const std::vector<std::vector<char>>& parts, int from, int to) {
        for (int i = from; i < to; ++i)
            tell([this, part = parts[std::size_t(i)]] { send(part); });
    }
    /// Then these bytes again and again, as fast as they are taken: for 20 s.
    void flood(const std::vector<char>& bytes) {
        tell([this, bytes] {
            for (const auto start = Clock::now(); seconds_since(start) < 20 && send(bytes);) {
            }
        });
    }
    /// Then closes the connection, and nobody listens.
    void close() {
        tell([this] { hang_up(); });
    }
    /// Then says that there is no more.
    void end() {
        tell([this] { ::shutdown(viewer_, SHUT_WR); });
    }
    /// The viewer has hung up within 20 s after all that.
    bool is_left() {
        std::promise<bool> left;
        tell([&] {
            const timeval patience{20, 0};
            ::setsockopt(viewer_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
            char byte = 0;
            left.set_value(::recv(viewer_, &byte, 1, 0) == 0);
        });
        return left.get_future().get();
    }

private:
    void tell(std::function<void()> task) {
        {
            const std::lock_guard lock(mutex_);
            tasks_.push_back(std::move(task));
        }
        changed_.notify_all();
    }

    void run() {
        std::unique_lock lock(mutex_);
        for (;;) {
            changed_.wait(lock, [&] { return stopping_ || !tasks_.empty(); });
            if (stopping_)
                return;
            const std::function<void()> task = std::move(tasks_.front());
            tasks_.pop_front();
            lock.unlock();
            task();
            std::this_thread::sleep_for(std::chrono::milliseconds(33));
            lock.lock();
        }
    }

    bool send(const std::vector<char>& part) {
        return is_there() && ::send(viewer_, part.data(), part.size(), MSG_NOSIGNAL) > 0;
    }
    void listen() {
        listening_ = ::socket(AF_INET, SOCK_STREAM, 0);
        const int again = 1;
        ::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &again, sizeof again);
        socklen_t size = sizeof address_;
        EXPECT_EQ(::bind(listening_, reinterpret_cast<const sockaddr*>(&address_), size), 0);
        EXPECT_EQ(::getsockname(listening_, reinterpret_cast<sockaddr*>(&address_), &size), 0);
        EXPECT_EQ(::listen(listening_, 1), 0);
    }
    bool is_there() {
        if (listening_ < 0)
            listen();
        while (viewer_ < 0) {
            pollfd waiting{listening_, POLLIN, 0};
            if (::poll(&waiting, 1, 50) > 0)
                viewer_ = ::accept(listening_, nullptr, nullptr);
            const std::lock_guard lock(mutex_);
            if (stopping_)
                return false;
        }
        return true;
    }
    void hang_up() {
        for (int* one : {&viewer_, &listening_})
            if (*one >= 0)
                ::close(std::exchange(*one, -1));
    }

    sockaddr_in address_ = [] {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        return address;
    }();
    int listening_ = -1, viewer_ = -1;  ///< the thread's own
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<std::function<void()>> tasks_;
    bool stopping_ = false;
    std::thread thread_;
};

}  // namespace equistream::test
