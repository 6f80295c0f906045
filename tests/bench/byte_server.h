#pragma once
/// 32 MB from a server of ours, as fast as whoever comes takes them. Neither Asio nor Boost.Asio is seen here: no file
/// may include both.
#include <client/transport/address.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace equistream::bench {

inline constexpr std::size_t sent_bytes = 32 << 20;
/// As a viewer's blocks are.
inline constexpr std::size_t block_bytes = 1 << 16;
inline constexpr const char* secret = "a-secret-of-this-benchmark";

const std::vector<char>& what_is_sent();

/// Serves on this machine, in a thread of its own, until it is destroyed. Each viewer is sent the bytes and the end.
class ByteServer {
public:
    /// `web`: browsers may come too.
    explicit ByteServer(Scheme scheme, bool web = false);
    ~ByteServer();
    ByteServer(const ByteServer&) = delete;
    ByteServer& operator=(const ByteServer&) = delete;

    /// With the secret.
    const std::string& url() const { return url_; }
    /// Where browsers come, on 127.0.0.1.
    std::uint16_t web_port() const;

private:
    struct Parts;

    std::unique_ptr<Parts> parts_;
    std::string url_;
};

}  // namespace equistream::bench
