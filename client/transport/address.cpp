#include "address.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>
#include <utility>

namespace equistream {

namespace {

/// In the order of Scheme; all are as long as each other.
constexpr std::array<std::string_view, 3> schemes{"tcp://", "tls://", "srt://"};
constexpr std::size_t scheme_chars = schemes[0].size();

std::optional<Scheme> scheme_of(std::string_view text) {
    const auto found = std::ranges::find(schemes, text.substr(0, scheme_chars));
    return found == schemes.end() ? std::nullopt : std::optional(Scheme(found - schemes.begin()));
}

/// All of the text.
template <typename Number>
std::optional<Number> number_of(std::string_view text) {
    Number number{};
    const char* const end = text.data() + text.size();
    const auto [stop, problem] = std::from_chars(text.data(), end, number);
    return problem == std::errc() && stop == end ? std::optional(number) : std::nullopt;
}

constexpr std::string_view parity_query = "?parity=";

/// Nothing where it is none, or out of range.
std::optional<int> parity_of(std::string_view query) {
    const auto parity =
        query.starts_with(parity_query) ? number_of<int>(query.substr(parity_query.size())) : std::nullopt;
    return parity && *parity >= min_parity && *parity <= max_parity ? parity : std::nullopt;
}

}  // namespace

std::string ServerAddress::text() const {
    const bool is_ipv6 = host.find(':') != std::string::npos;
    return std::string(schemes[std::size_t(scheme)]) + (is_ipv6 ? "[" + host + "]" : host) + ":" +
           std::to_string(port) + (parity ? std::string(parity_query) + std::to_string(*parity) : "");
}

std::string ServerAddress::text_with_secret() const {
    std::string all = text();
    return secret.empty() ? all : all.insert(scheme_chars, secret + "@");
}

std::optional<ServerAddress> parse_server_address(const std::string& source) {
    const auto scheme = scheme_of(source);
    if (!scheme)
        return std::nullopt;
    ServerAddress address{.scheme = *scheme};
    std::string_view rest = std::string_view(source).substr(scheme_chars);
    if (const auto at = rest.rfind('@'); is_encrypted(*scheme) && at != std::string_view::npos) {
        address.secret = rest.substr(0, at);
        rest.remove_prefix(at + 1);
    }
    if (const auto query = rest.find('?'); query != std::string_view::npos) {
        address.parity = parity_of(rest.substr(query));
        if (!address.parity || *scheme != Scheme::srt)
            return std::nullopt;
        rest = rest.substr(0, query);
    }
    const auto colon = rest.rfind(':');
    if (colon == std::string_view::npos)
        return std::nullopt;
    const auto port = number_of<std::uint16_t>(rest.substr(colon + 1));
    if (!port)
        return std::nullopt;
    address.port = *port;
    std::string_view host = rest.substr(0, colon);
    if (host.starts_with('[') && host.ends_with(']'))
        host = host.substr(1, host.size() - 2);
    else if (host.find_first_of("/:[]@") != std::string_view::npos)
        return std::nullopt;
    address.host = host;
    return address;
}

bool names_server(const std::string& source) {
    return scheme_of(source).has_value();
}

std::string without_secrets(std::string text) {
    constexpr std::string_view mark = "://";
    for (std::size_t found = text.find(mark); found != std::string::npos; found = text.find(mark, found)) {
        found += mark.size();
        const bool is_ours = std::ranges::any_of(schemes, [&](std::string_view scheme) {
            return found >= scheme.size() && text.compare(found - scheme.size(), scheme.size(), scheme) == 0;
        });
        // A server's secret may have slashes; who comes to another address may not.
        const std::size_t end = text.find_first_of(is_ours ? " \t\n" : "/?# \t\n", found);
        const std::size_t at = text.rfind('@', end);
        if (at != std::string::npos && at > found)
            text.replace(found, at - found, "***");
    }
    return text;
}

}  // namespace equistream
