#pragma once
/// Where a server is and how it is spoken to: tcp://HOST:PORT, tls://SECRET@HOST:PORT or
/// srt://SECRET@HOST:PORT?parity=N.
#include <cstdint>
#include <optional>
#include <string>

namespace equistream {

enum class Scheme { tcp, tls, srt };

/// Whether both ends must know a secret.
constexpr bool is_encrypted(Scheme scheme) {
    return scheme != Scheme::tcp;
}

struct ServerAddress {
    Scheme scheme = Scheme::tcp;
    std::string
        host{};  ///< a name, an IPv4 address, or an IPv6 address without brackets; may be empty where one listens
    std::uint16_t port = 0;
    std::string secret{};  ///< as the address says it; empty: it says none
    /// Of srt:// alone: N, of a packet of parity for each row and column of N others (make_srt_socket()), in both
    /// directions. Both ends must say the same.
    std::optional<int> parity{};

    /// "tls://HOST:PORT": the secret is left out.
    std::string text() const;
    /// The same with the secret, for those who may come.
    std::string text_with_secret() const;
};

/// Where clients and servers find a secret that no address and no option says.
inline constexpr const char* secret_variable = "EQUISTREAM_SECRET";

/// Of `ServerAddress::parity`.
inline constexpr int min_parity = 2, usual_parity = 10, max_parity = 100;

/// Nothing for what is no such address. tcp:// has no secret.
std::optional<ServerAddress> parse_server_address(const std::string& source);

/// Whether it says that it is one: it begins with tcp://, tls:// or srt://.
bool names_server(const std::string& source);

/// The text with "***" for every secret in an address of it.
std::string without_secrets(std::string text);

}  // namespace equistream
