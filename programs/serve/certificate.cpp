#include "certificate.h"

#include <client/transport/private_file.h>
#include <equistream/error.h>
#include <equistream/text.h>

#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>

#include <unistd.h>

#include <array>
#include <memory>

namespace equistream::serve {

namespace {

constexpr long valid_s = 365 * 86400L, clocks_apart_s = 86400;

template <auto Free>
struct Freed {
    template <typename Thing>
    void operator()(Thing* thing) const {
        Free(thing);
    }
};
using Key = std::unique_ptr<EVP_PKEY, Freed<EVP_PKEY_free>>;
using X509Certificate = std::unique_ptr<X509, Freed<X509_free>>;
using Extension = std::unique_ptr<X509_EXTENSION, Freed<X509_EXTENSION_free>>;
using Memory = std::unique_ptr<BIO, Freed<BIO_free_all>>;

void require(bool done) {
    if (!done)
        throw WorkError("OpenSSL cannot make a certificate for https://");
}

std::string machine_name() {
    std::array<char, 256> name{};
    return gethostname(name.data(), name.size() - 1) == 0 && name[0] != '\0' ? name.data() : "localhost";
}

void add_extension(X509* certificate, int number, const std::string& value) {
    X509V3_CTX context;
    X509V3_set_ctx(&context, certificate, certificate, nullptr, nullptr, 0);
    const Extension extension(X509V3_EXT_conf_nid(nullptr, &context, number, value.c_str()));
    require(extension && X509_add_ext(certificate, extension.get(), -1) == 1);
}

X509Certificate signed_by(EVP_PKEY* key) {
    X509Certificate certificate(X509_new());
    std::array<unsigned char, 16> serial{};
    require(certificate && RAND_bytes(serial.data(), int(serial.size())) == 1);
    serial[0] = static_cast<unsigned char>((serial[0] & 0x7f) | 1);
    const std::unique_ptr<BIGNUM, Freed<BN_free>> number(BN_bin2bn(serial.data(), int(serial.size()), nullptr));
    require(number && BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(certificate.get())) != nullptr);
    const std::string name = machine_name();
    X509_NAME* const subject = X509_get_subject_name(certificate.get());
    require(X509_set_version(certificate.get(), X509_VERSION_3) == 1 &&
            X509_gmtime_adj(X509_getm_notBefore(certificate.get()), -clocks_apart_s) != nullptr &&
            X509_gmtime_adj(X509_getm_notAfter(certificate.get()), valid_s) != nullptr &&
            X509_NAME_add_entry_by_txt(subject, "CN", MBSTRING_UTF8,
                                       reinterpret_cast<const unsigned char*>("equistream serve"), -1, -1, 0) == 1 &&
            X509_set_issuer_name(certificate.get(), subject) == 1 && X509_set_pubkey(certificate.get(), key) == 1);
    add_extension(certificate.get(), NID_subject_alt_name, "DNS:" + name + ",DNS:localhost,IP:127.0.0.1,IP:::1");
    add_extension(certificate.get(), NID_ext_key_usage, "serverAuth");
    require(X509_sign(certificate.get(), key, EVP_sha256()) > 0);
    return certificate;
}

std::string fingerprint_of(const X509* certificate) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    require(X509_digest(certificate, EVP_sha256(), digest.data(), &size) == 1);
    std::string text;
    for (unsigned int i = 0; i < size; ++i)
        text += formatted(i == 0 ? "%02X" : ":%02X", digest[i]);
    return text;
}

}  // namespace

Certificate make_certificate() {
    const Key key(EVP_EC_gen("P-256"));
    require(key != nullptr);
    const X509Certificate certificate = signed_by(key.get());
    const Memory memory(BIO_new(BIO_s_mem()));
    require(memory && PEM_write_bio_PrivateKey(memory.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1 &&
            PEM_write_bio_X509(memory.get(), certificate.get()) == 1);
    char* bytes = nullptr;
    const long size = BIO_get_mem_data(memory.get(), &bytes);
    return {std::string(bytes, std::size_t(size)), fingerprint_of(certificate.get())};
}

Certificate read_or_make_certificate(const std::filesystem::path& file) {
    Certificate made;
    if (make_private_file(file, [&] { return (made = make_certificate()).pem; }))
        return made;
    Certificate read{read_private_file(file), ""};
    const Memory for_key(BIO_new_mem_buf(read.pem.data(), int(read.pem.size()))),
        for_certificate(BIO_new_mem_buf(read.pem.data(), int(read.pem.size())));
    char no_password[] = "";  // it would be asked for on the terminal
    const Key key(PEM_read_bio_PrivateKey(for_key.get(), nullptr, nullptr, no_password));
    const X509Certificate certificate(PEM_read_bio_X509(for_certificate.get(), nullptr, nullptr, no_password));
    if (!key || !certificate || X509_check_private_key(certificate.get(), key.get()) != 1)
        throw InputError(expected_found(file.string(), "a private key and its certificate, as PEM without a password",
                                        "something else"));
    if (X509_cmp_current_time(X509_get0_notAfter(certificate.get())) < 0)
        throw InputError(expected_found(file.string(), "a certificate that has not expired",
                                        "one that has; remove the file to have one made"));
    read.fingerprint = fingerprint_of(certificate.get());
    return read;
}

}  // namespace equistream::serve
