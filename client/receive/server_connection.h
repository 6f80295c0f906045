#pragma once
/// A connection to a server, on which a stream comes and poses go.
#include "receive.h"

#include <equistream/elapsed.h>

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// tcp://HOST:PORT and nothing behind it.
bool is_server_address(const std::string& source);

/// One thread, but for what `poses` sends.
class ServerConnection {
public:
    /// Connects; `poses` sends there until it is closed or given up. `interrupted` (may be empty) is asked while there
    /// is nothing to do but wait. Throws InputError where nobody answers, and WorkError where that takes too long.
    ServerConnection(const std::string& address, PoseSender& poses, std::function<bool()> interrupted,
                     const Patience& patience = {});
    ~ServerConnection();
    ServerConnection(const ServerConnection&) = delete;
    ServerConnection& operator=(const ServerConnection&) = delete;

    /// As StreamReadOptions::read. Throws WorkError where the server is silent for too long.
    std::size_t read(std::span<std::uint8_t> bytes);

private:
    enum class Waited { done, interrupted, too_long };
    Waited wait_until(const bool& done, double limit_s);
    void keep_alive();
    bool send(std::span<const std::uint8_t> bytes);

    PoseSender& poses_;
    std::function<bool()> interrupted_;
    Patience patience_;
    asio::io_context io_{1};
    asio::ip::tcp::socket socket_{io_};
    bool has_sent_ = false, has_ended_ = false;  // the server
    std::vector<std::uint8_t> unsent_;           // the rest of a message of which some has gone; used by whoever sends
};

}  // namespace equistream
