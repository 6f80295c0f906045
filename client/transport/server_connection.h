#pragma once
/// A connection to a server, on which a stream comes and poses go.
#include "pose_sender.h"

#include <equistream/elapsed.h>
#include <equistream/stream.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace equistream {

/// Works in a thread of its own. One thread reads; any may send.
class ServerConnection {
public:
    /// Connects to a server's address (address.h); a secret that it does not say is the environment's. `poses`, if
    /// there is one, sends there until the connection is closed or given up. `interrupted` (may be empty) is asked
    /// while there is nothing to do but wait. Throws InputError where nobody answers or the secret is another, and
    /// WorkError where that takes too long.
    ServerConnection(const std::string& address, PoseSender* poses, std::function<bool()> interrupted,
                     const Patience& patience = {});
    ~ServerConnection();
    ServerConnection(const ServerConnection&) = delete;
    ServerConnection& operator=(const ServerConnection&) = delete;

    /// As StreamReadOptions::read. Throws WorkError where the server is silent for too long.
    std::size_t read(std::span<std::uint8_t> bytes);

private:
    class Line;

    void give_up();

    PoseSender* poses_;
    std::function<bool()> interrupted_;
    Patience patience_;
    bool has_sent_ = false, has_ended_ = false;  // the server
    std::unique_ptr<Line> line_;
};

/// The same options; where the source is a server's address, they read from a connection to it, which is made here and
/// lives as long as they do. Throws as it does.
StreamReadOptions connected(const std::string& source, StreamReadOptions options, PoseSender* poses = nullptr);

}  // namespace equistream
