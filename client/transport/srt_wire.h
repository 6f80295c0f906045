#pragma once
/// TLS within SRT (draft-sharabayko-srt-01): bytes over UDP. What is lost is asked for again by its number, and later
/// packets do not wait in the network for it. How much is on its way follows what arrives (delivery_window.h).
/// SRT's own encryption is not used: it does not prove that the other end knows the secret.
#include "wire.h"

#include <asio/ip/udp.hpp>

#include <functional>
#include <memory>

namespace equistream {

/// Both ends must use the same `parity` (address.h); open() fails with other_parity where they do not. Not connected
/// yet: open() does that first. It fails with an error of asio::system_category() where no server answers within
/// `connect_s`, with another where the secret is another. An end that says nothing for twice `patience_s`, and for 5 s
/// at least, is taken to have gone. Throws WorkError where the system has no room.
std::unique_ptr<Wire> srt_wire(const asio::any_io_executor& executor, const asio::ip::udp::endpoint& server,
                               std::shared_ptr<asio::ssl::context> context, double patience_s, double connect_s,
                               int parity);

class SrtListener {
public:
    using Accepted = std::function<void(const asio::error_code&, std::unique_ptr<Wire>, asio::ip::udp::endpoint)>;

    /// Bound, not yet listening. `context`: of the secret that whoever comes must know. Throws WorkError with the
    /// reason.
    SrtListener(const asio::any_io_executor& executor, const asio::ip::udp::endpoint& address,
                std::shared_ptr<asio::ssl::context> context, double patience_s, int parity);
    ~SrtListener();
    SrtListener(const SrtListener&) = delete;
    SrtListener& operator=(const SrtListener&) = delete;

    asio::ip::udp::endpoint address() const;
    /// Once, before accept(). Throws WorkError with the reason.
    void listen();
    /// One call waits at a time.
    void accept(Accepted accepted);
    /// A call that waits fails.
    void close();
    bool is_open() const;

private:
    class State;
    std::shared_ptr<State> state_;
};

}  // namespace equistream
