#include "server_connection.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <asio/buffer.hpp>
#include <asio/connect.hpp>

#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace equistream {

using asio::ip::tcp;

constexpr std::string_view scheme = "tcp://";
constexpr std::chrono::milliseconds between_questions{50};

bool is_server_address(const std::string& source) {
    const auto colon = source.rfind(':');
    if (!source.starts_with(scheme) || colon <= scheme.size())
        return false;
    std::uint16_t port = 0;
    const char* const end = source.data() + source.size();
    const auto [stop, problem] = std::from_chars(source.data() + colon + 1, end, port);
    return problem == std::errc() && stop == end && port > 0;
}

ServerConnection::ServerConnection(const std::string& address, PoseSender& poses, std::function<bool()> interrupted,
                                   const Patience& patience)
    : poses_(poses), interrupted_(std::move(interrupted)), patience_(patience) {
    const auto colon = address.rfind(':');
    std::string host = address.substr(scheme.size(), colon - scheme.size());
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    asio::error_code problem;
    tcp::resolver resolver(io_);
    const auto found = resolver.resolve(host, address.substr(colon + 1), problem);
    if (!problem) {
        bool done = false;
        asio::async_connect(socket_, found, [&](const asio::error_code& error, const tcp::endpoint&) {
            problem = error;
            done = true;
        });
        if (wait_until(done, patience_.connect_s) == Waited::too_long)
            throw WorkError(formatted("%s: the server did not answer for %g s", address.c_str(), patience_.connect_s));
    }
    if (problem)
        throw InputError(expected_found(address, "a server", problem.message()));
    keep_alive();
    poses_.use([this](std::span<const std::uint8_t> bytes) { return send(bytes); });
}

ServerConnection::~ServerConnection() {
    poses_.use(nullptr);
}

/// Poses that nobody takes end the connection too, of a server that vanished while it had nothing to send.
void ServerConnection::keep_alive() {
    asio::error_code ignored;
    socket_.set_option(tcp::no_delay(true), ignored);
    socket_.set_option(asio::socket_base::keep_alive(true), ignored);
    const auto silence_ms = unsigned(patience_.silence_s * 1000);
    setsockopt(socket_.native_handle(), IPPROTO_TCP, TCP_USER_TIMEOUT, &silence_ms, sizeof silence_ms);
}

/// Unless it is done, what was waited for has been given up.
ServerConnection::Waited ServerConnection::wait_until(const bool& done, double limit_s) {
    const auto start = Clock::now();
    while (!done) {
        io_.restart();
        io_.run_for(between_questions);
        const bool interrupted = !done && interrupted_ && interrupted_();
        if (!interrupted && (done || seconds_since(start) <= limit_s))
            continue;
        poses_.use(nullptr);  // whatever is opened next may get the socket's number
        asio::error_code ignored;
        socket_.close(ignored);
        io_.restart();
        io_.run();
        return interrupted ? Waited::interrupted : Waited::too_long;
    }
    return Waited::done;
}

std::size_t ServerConnection::read(std::span<std::uint8_t> bytes) {
    // libav reads on beyond an end, and Asio waits for ever where that was read already.
    if (has_ended_)
        return 0;
    // Bytes that nothing can be made of may come without a pause: then nothing below ever waits.
    if (interrupted_ && interrupted_()) {
        has_ended_ = true;
        return 0;
    }
    bool done = false;
    std::size_t got = 0;
    socket_.async_read_some(asio::buffer(bytes.data(), bytes.size()),
                            [&](const asio::error_code& error, std::size_t count) {
                                got = error ? 0 : count;
                                done = true;
                            });
    const double limit_s = has_sent_ ? patience_.silence_s : patience_.first_bytes_s;
    const Waited waited = wait_until(done, limit_s);
    has_ended_ = got == 0;
    has_sent_ = true;
    if (waited == Waited::too_long)
        throw WorkError(formatted("the server sent nothing for %g s", limit_s));
    return got;
}

/// Directly, beside a read that waits in another thread: a message is small, and one that finds no room is lost.
bool ServerConnection::send(std::span<const std::uint8_t> bytes) {
    const auto send_some = [this](std::span<const std::uint8_t> some) {
        const ssize_t count = ::send(socket_.native_handle(), some.data(), some.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
        return std::size_t(std::max<ssize_t>(count, 0));
    };
    unsent_.erase(unsent_.begin(), unsent_.begin() + std::ptrdiff_t(send_some(unsent_)));
    if (!unsent_.empty())
        return false;
    const std::size_t count = send_some(bytes);
    if (count > 0)
        unsent_.assign(bytes.begin() + std::ptrdiff_t(count), bytes.end());
    return count > 0;
}

}  // namespace equistream
