#include "file_bytes.h"

#include <equistream/error.h>

#include <cinttypes>
#include <cstdio>
#include <fstream>

#include <xxhash.h>

namespace equistream {

namespace fs = std::filesystem;

std::ifstream open_regular_file(const fs::path& file, const std::string& what) {
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (!fs::exists(status))
        throw InputError(expected_found(file.string(), "a " + what, "no such file"));
    if (!fs::is_regular_file(status))
        throw InputError(expected_found(file.string(), "a " + what, "something that is not a regular file"));
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw InputError(expected_found(file.string(), "a readable " + what, "a file that cannot be opened"));
    return stream;
}

std::vector<std::uint8_t> read_file_bytes(const fs::path& file, const std::string& what, std::uint64_t limit_bytes) {
    std::ifstream stream = open_regular_file(file, what);
    std::error_code error;
    const std::uint64_t size = fs::file_size(file, error);
    if (error)
        throw InputError(expected_found(file.string(), "a readable " + what, error.message()));
    if (size > limit_bytes)
        throw InputError(expected_found(file.string(),
                                        "a " + what + " of at most " + std::to_string(limit_bytes) + " bytes",
                                        std::to_string(size) + " bytes"));
    std::vector<std::uint8_t> bytes(size);
    stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uint64_t>(stream.gcount()) != size)
        throw InputError(expected_found(file.string(), std::to_string(size) + " bytes of " + what,
                                        std::to_string(stream.gcount()) + " bytes that could be read"));
    return bytes;
}

void ContentHash::add(std::span<const std::uint8_t> bytes) {
    state_ = XXH64(bytes.data(), bytes.size(), state_);
}

void ContentHash::add(const std::string& text) {
    add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

void ContentHash::add_file(const fs::path& file, const std::string& what) {
    std::ifstream stream = open_regular_file(file, what);
    std::vector<std::uint8_t> block(std::size_t{1} << 20);
    while (stream) {
        stream.read(reinterpret_cast<char*>(block.data()), static_cast<std::streamsize>(block.size()));
        add({block.data(), static_cast<std::size_t>(stream.gcount())});
    }
    if (stream.bad())
        throw InputError(expected_found(file.string(), "a readable " + what, "a read error"));
}

std::string ContentHash::hex() const {
    char text[17];
    std::snprintf(text, sizeof text, "%016" PRIx64, state_);
    return text;
}

}  // namespace equistream
