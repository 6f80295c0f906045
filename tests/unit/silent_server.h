#pragma once
/// A server on this machine that accepts a viewer, sends it some bytes, and then nothing more; or accepts nobody. It
/// hears what the viewer says.
#include <gtest/gtest.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace equistream::test {

class SilentServer {
public:
    /// The system completes connections for it, as many as `room` allows. `host`: an address of this machine; `port`: 0
    /// is any.
    explicit SilentServer(int room = 4, const char* host = "127.0.0.1", std::uint16_t port = 0)
        : listening_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
        address_.sin_family = AF_INET;
        address_.sin_addr.s_addr = ::inet_addr(host);
        address_.sin_port = htons(port);
        socklen_t size = sizeof address_;
        EXPECT_EQ(::bind(listening_, reinterpret_cast<const sockaddr*>(&address_), size), 0);
        EXPECT_EQ(::getsockname(listening_, reinterpret_cast<sockaddr*>(&address_), &size), 0);
        EXPECT_EQ(::listen(listening_, room), 0);
    }
    ~SilentServer() {
        for (const int one : sockets_)
            ::close(one);
        ::close(listening_);
    }
    SilentServer(const SilentServer&) = delete;
    SilentServer& operator=(const SilentServer&) = delete;

    std::uint16_t port() const { return ntohs(address_.sin_port); }
    std::string address() const { return "tcp://127.0.0.1:" + std::to_string(port()); }

    /// To the next viewer, which is waited for.
    void send(const std::string& bytes) {
        sockets_.push_back(::accept(listening_, nullptr, nullptr));
        EXPECT_EQ(::send(sockets_.back(), bytes.data(), bytes.size(), MSG_NOSIGNAL), ssize_t(bytes.size()));
    }
    /// To the next viewer, byte by byte, until all is sent or the viewer has gone.
    void trickle(const std::string& bytes, std::chrono::milliseconds pause) {
        send(bytes.substr(0, 1));
        for (std::size_t i = 1; i < bytes.size() && ::send(sockets_.back(), &bytes[i], 1, MSG_NOSIGNAL) == 1; ++i)
            std::this_thread::sleep_for(pause);
    }
    /// What that viewer says, until it has said so much; empty where it says less within 5 s.
    std::vector<std::uint8_t> hear(std::size_t bytes) {
        std::vector<std::uint8_t> heard(bytes);
        const timeval limit{5, 0};
        ::setsockopt(sockets_.back(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
        const ssize_t found = ::recv(sockets_.back(), heard.data(), heard.size(), MSG_WAITALL);
        return found == ssize_t(bytes) ? heard : std::vector<std::uint8_t>{};
    }
    /// Others take all its room: the system does not answer whoever comes then.
    void fill_up(int room) {
        for (int i = 0; i <= room; ++i) {
            sockets_.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
            ::connect(sockets_.back(), reinterpret_cast<const sockaddr*>(&address_), sizeof address_);
        }
    }

private:
    int listening_;
    sockaddr_in address_{};
    std::vector<int> sockets_;
};

}  // namespace equistream::test
