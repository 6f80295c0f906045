#include "png_check.h"

#include <isa-l/crc.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <fstream>
#include <istream>
#include <streambuf>
#include <vector>

namespace equistream {
namespace {

constexpr std::array<char, 8> signature = {'\x89', 'P', 'N', 'G', '\r', '\n', '\x1a', '\n'};
constexpr std::size_t block_bytes = 1 << 16;

/// Bytes in memory as a stream reads them.
class BytesBuffer : public std::streambuf {
public:
    explicit BytesBuffer(std::span<const std::uint8_t> bytes) {
        char* begin = const_cast<char*>(reinterpret_cast<const char*>(bytes.data()));
        setg(begin, begin, begin + bytes.size());
    }
};

/// Reads a stream and keeps the checksum of what it read since the last restart.
class ChecksummedReader {
public:
    explicit ChecksummedReader(std::istream& stream) : stream_(stream) {}

    bool read(void* to, std::size_t bytes) {
        stream_.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
        if (!stream_)
            return false;
        checksum_ = crc32_gzip_refl(checksum_, static_cast<const unsigned char*>(to), bytes);
        return true;
    }
    bool pass_over(std::size_t bytes) {
        for (std::size_t left = bytes; left > 0;) {
            const std::size_t part = std::min(left, block_.size());
            if (!read(block_.data(), part))
                return false;
            left -= part;
        }
        return true;
    }
    /// Most significant byte first.
    std::optional<std::uint32_t> read_number() {
        std::array<unsigned char, 4> b{};
        if (!read(b.data(), b.size()))
            return std::nullopt;
        return static_cast<std::uint32_t>(b[0]) << 24 | static_cast<std::uint32_t>(b[1]) << 16 |
               static_cast<std::uint32_t>(b[2]) << 8 | static_cast<std::uint32_t>(b[3]);
    }
    void restart_checksum() { checksum_ = 0; }
    std::uint32_t checksum() const { return checksum_; }

private:
    std::istream& stream_;
    std::vector<char> block_ = std::vector<char>(block_bytes);
    std::uint32_t checksum_ = 0;
};

std::optional<std::string> damage_in(std::istream& stream) {
    ChecksummedReader in(stream);
    std::array<char, 8> begin{};
    if (!in.read(begin.data(), begin.size()) || begin != signature)
        return std::nullopt;
    const std::string cut = "one that ends early";
    for (;;) {
        const auto length = in.read_number();
        in.restart_checksum();  // of the chunk's type and content
        std::array<char, 4> type{};
        if (!length || !in.read(type.data(), type.size()))
            return cut;
        if (!std::all_of(type.begin(), type.end(), [](unsigned char c) { return std::isalpha(c); }))
            return "damage between its chunks";
        if (!in.pass_over(*length))
            return cut;
        const std::uint32_t found = in.checksum();
        const auto expected = in.read_number();
        if (!expected)
            return cut;
        const std::string name(type.begin(), type.end());
        if (*expected != found)
            return "a damaged chunk " + name;
        if (name == "IEND")
            return std::nullopt;
    }
}

}  // namespace

std::optional<std::string> png_damage(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return damage_in(stream);
}

std::optional<std::string> png_damage(std::span<const std::uint8_t> bytes) {
    BytesBuffer buffer(bytes);
    std::istream stream(&buffer);
    return damage_in(stream);
}

}  // namespace equistream
