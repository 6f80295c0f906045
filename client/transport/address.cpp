#include "address.h"

#include <charconv>
#include <string_view>
#include <utility>

namespace equistream {

namespace {

constexpr std::string_view plain = "tcp://", encrypted = "tls://";

}  // namespace

std::string ServerAddress::text() const {
    const bool is_ipv6 = host.find(':') != std::string::npos;
    return std::string(encrypted ? equistream::encrypted : plain) + (is_ipv6 ? "[" + host + "]" : host) + ":" +
           std::to_string(port);
}

std::string ServerAddress::text_with_secret() const {
    std::string all = text();
    return secret.empty() ? all : all.insert(equistream::encrypted.size(), secret + "@");
}

std::optional<ServerAddress> parse_server_address(const std::string& source) {
    ServerAddress address;
    if (!names_server(source))
        return std::nullopt;
    address.encrypted = source.starts_with(encrypted);
    std::string_view rest = std::string_view(source).substr(plain.size());
    if (const auto at = rest.rfind('@'); address.encrypted && at != std::string_view::npos) {
        address.secret = rest.substr(0, at);
        rest.remove_prefix(at + 1);
    }
    const auto colon = rest.rfind(':');
    if (colon == std::string_view::npos)
        return std::nullopt;
    const char* const end = rest.data() + rest.size();
    const auto [stop, problem] = std::from_chars(rest.data() + colon + 1, end, address.port);
    if (problem != std::errc() || stop != end)
        return std::nullopt;
    std::string_view host = rest.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    else if (host.find_first_of("/:[]@") != std::string_view::npos)
        return std::nullopt;
    address.host = host;
    return address;
}

bool names_server(const std::string& source) {
    return source.starts_with(plain) || source.starts_with(encrypted);
}

std::string without_secrets(std::string text) {
    for (std::size_t found = text.find(encrypted); found != std::string::npos; found = text.find(encrypted, found)) {
        found += encrypted.size();
        const std::size_t end = text.find_first_of(" \t\n'\"", found);
        const std::size_t at = text.rfind('@', end);
        if (at != std::string::npos && at > found)
            text.replace(found, at - found, "***");
    }
    return text;
}

}  // namespace equistream
