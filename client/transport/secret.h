#pragma once
/// A secret that server and client share: the external pre-shared key of TLS 1.3 (RFC 8446, 2.2), with (EC)DHE.
/// By it TLS encrypts, and each end knows the other. There are no certificates. Who learns the secret later cannot read
/// what was sent before.
///
/// Who listens can try secrets against what was sent, one after the other. What `make_secret` gives is beyond that; a
/// word of a dictionary is not.
#include "address.h"

#include <asio/ssl/context.hpp>

#include <filesystem>
#include <memory>
#include <string>

namespace equistream {

inline constexpr std::size_t min_secret_chars = 16, max_secret_chars = 128;

/// 130 random bits, as letters and digits.
std::string make_secret();

/// Throws InputError naming `where` unless it has 16 to 128 characters, all of them visible, without @, quotes and
/// backslashes.
void require_secret(const std::string& secret, const std::string& where);

/// The first line of a file, which must be its owner's alone. One that is not there is made, with a new secret. Throws
/// InputError or WorkError.
std::string read_or_make_secret(const std::filesystem::path& file);

enum class TlsRole { server, client };

/// What connections of this secret are made with; must outlive them. Throws WorkError where OpenSSL cannot.
std::shared_ptr<asio::ssl::context> secret_context(const std::string& secret, TlsRole role);

}  // namespace equistream
