#pragma once
/// SRT (draft-sharabayko-srt): bytes over UDP that lost packets do not hold up as they do TCP's: each is asked for
/// again by its number, and the sender does not slow down for it. All bytes come, in order. Encrypted by the secret
/// (AES-CTR).
#include "wire.h"

#include <asio/ip/udp.hpp>

#include <functional>
#include <memory>
#include <string>

namespace equistream {

struct SrtSettings {
    std::string secret;      ///< empty: not encrypted
    double patience_s = 10;  ///< with an end that says nothing
    double mbit_s = 0;       ///< at most, what is sent again included; 0: as fast as it is written
};

/// Not connected yet: open() does it, and fails with asio::error::access_denied where the secret is another.
std::unique_ptr<Wire> srt_wire(const asio::any_io_executor& executor, const asio::ip::udp::endpoint& server,
                               const SrtSettings& settings);

class SrtListener {
public:
    using Accepted = std::function<void(const asio::error_code&, std::unique_ptr<Wire>, asio::ip::udp::endpoint)>;

    /// Bound, not yet listening. Throws WorkError with the reason.
    SrtListener(const asio::any_io_executor& executor, const asio::ip::udp::endpoint& address,
                const SrtSettings& settings);
    ~SrtListener();
    SrtListener(const SrtListener&) = delete;
    SrtListener& operator=(const SrtListener&) = delete;

    asio::ip::udp::endpoint address() const;
    /// Once, before accept(). Throws the same.
    void listen();
    /// Of those who know the secret; one call waits at a time.
    void accept(Accepted accepted);
    /// A call that waits fails.
    void close();
    bool is_open() const;

private:
    class State;
    std::shared_ptr<State> state_;
};

}  // namespace equistream
