#include "secret.h"

#include "private_file.h"

#include <equistream/error.h>
#include <equistream/text.h>

#include <openssl/evp.h>
#include <openssl/rand.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <array>

namespace equistream {

namespace {

// RFC 8446, B.4. One cipher, as the key belongs to its hash.
constexpr const char* cipher_name = "TLS_AES_128_GCM_SHA256";
constexpr std::array<unsigned char, 2> cipher_number{0x13, 0x01};

constexpr std::string_view identity = "equistream";
constexpr std::string_view letters = "abcdefghijklmnopqrstuvwxyz234567";
constexpr std::size_t made_chars = 26;

using Key = std::array<unsigned char, 32>;

struct Secret {
    asio::ssl::context context;
    Key key{};
};

int key_index() {
    static const int index = SSL_CTX_get_ex_new_index(0, nullptr, nullptr, nullptr, nullptr);
    return index;
}

/// Null where OpenSSL has no room.
SSL_SESSION* session_of(SSL* ssl) {
    const auto* key = static_cast<const Key*>(SSL_CTX_get_ex_data(SSL_get_SSL_CTX(ssl), key_index()));
    const SSL_CIPHER* cipher = SSL_CIPHER_find(ssl, cipher_number.data());
    SSL_SESSION* session = SSL_SESSION_new();
    if (session != nullptr && key != nullptr && cipher != nullptr &&
        SSL_SESSION_set1_master_key(session, key->data(), key->size()) == 1 &&
        SSL_SESSION_set_cipher(session, cipher) == 1 && SSL_SESSION_set_protocol_version(session, TLS1_3_VERSION) == 1)
        return session;
    SSL_SESSION_free(session);
    return nullptr;
}

/// 1 with a null session: the handshake goes on without it, and fails, as there are no certificates.
int find_session(SSL* ssl, const unsigned char* name, std::size_t length, SSL_SESSION** session) {
    const bool is_ours = std::string_view(reinterpret_cast<const char*>(name), length) == identity;
    *session = is_ours ? session_of(ssl) : nullptr;
    return 1;
}

int use_session(SSL* ssl, const EVP_MD* hash, const unsigned char** name, std::size_t* length, SSL_SESSION** session) {
    *session = hash == nullptr || EVP_MD_is_a(hash, "SHA256") ? session_of(ssl) : nullptr;
    *name = reinterpret_cast<const unsigned char*>(identity.data());
    *length = identity.size();
    return 1;
}

Key key_of(const std::string& secret) {
    Key key{};
    unsigned int length = 0;
    if (EVP_Digest(secret.data(), secret.size(), key.data(), &length, EVP_sha256(), nullptr) != 1)
        throw WorkError("OpenSSL has no SHA-256");
    return key;
}

bool is_visible(char c) {
    return c > ' ' && c < 0x7f && std::string_view("@'\"\\").find(c) == std::string_view::npos;
}

}  // namespace

std::string make_secret() {
    std::array<unsigned char, made_chars> bytes{};
    if (RAND_bytes(bytes.data(), int(bytes.size())) != 1)
        throw WorkError("OpenSSL has no random numbers");
    std::string secret;
    for (const unsigned char byte : bytes)
        secret += letters[byte % letters.size()];
    return secret;
}

void require_secret(const std::string& secret, const std::string& where) {
    if (secret.size() < min_secret_chars || secret.size() > max_secret_chars)
        throw InputError(
            expected_found(where, "a secret of 16 to 128 characters", std::to_string(secret.size()) + " characters"));
    if (!std::ranges::all_of(secret, is_visible))
        throw InputError(expected_found(where, "a secret of printable ASCII without spaces, @, quotes and backslashes",
                                        "other characters"));
}

std::string read_or_make_secret(const std::filesystem::path& file) {
    std::string secret;
    if (make_private_file(file, [&] { return (secret = make_secret()) + "\n"; }))
        return secret;
    const std::string text = read_private_file(file);
    if (text.empty())
        throw InputError(expected_found(file.string(), "a file whose first line is a secret",
                                        "an empty file; remove it to have one made"));
    secret = text.substr(0, text.find('\n'));
    require_secret(secret, file.string());
    return secret;
}

std::shared_ptr<asio::ssl::context> secret_context(const std::string& secret, TlsRole role) {
    const bool is_server = role == TlsRole::server;
    const auto made = std::make_shared<Secret>(
        Secret{asio::ssl::context(is_server ? asio::ssl::context::tls_server : asio::ssl::context::tls_client),
               key_of(secret)});
    SSL_CTX* const context = made->context.native_handle();
    if (SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION) != 1 ||
        SSL_CTX_set_ciphersuites(context, cipher_name) != 1 ||
        SSL_CTX_set_ex_data(context, key_index(), &made->key) != 1)
        throw WorkError("OpenSSL cannot speak TLS 1.3");
    // A client takes nobody's certificate: it trusts no authority.
    SSL_CTX_set_verify(context, is_server ? SSL_VERIFY_NONE : SSL_VERIFY_PEER, nullptr);
    if (is_server)
        SSL_CTX_set_psk_find_session_callback(context, find_session);
    else
        SSL_CTX_set_psk_use_session_callback(context, use_session);
    SSL_CTX_set_num_tickets(context, 0);
    return {made, &made->context};
}

}  // namespace equistream
