#pragma once
/// By what browsers speak https:// to this server. A certificate that is made here has nobody who vouches for it:
/// browsers ask their user whether to go on, and show its fingerprint.
#include <filesystem>
#include <string>

namespace equistream::serve {

struct Certificate {
    std::string pem;          ///< the private key, the certificate, and those that vouch for it
    std::string fingerprint;  ///< the certificate's SHA-256, as browsers show it: "0A:1B:..."
};

/// For this machine's name and localhost, for a year; of ECDSA with P-256. Throws WorkError where OpenSSL cannot.
Certificate make_certificate();

/// One that is not there is made. Throws InputError where the file is not its owner's alone, or holds no key and
/// certificate that belong together.
Certificate read_or_make_certificate(const std::filesystem::path& file);

}  // namespace equistream::serve
