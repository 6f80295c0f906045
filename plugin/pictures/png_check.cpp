#include "png_check.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <vector>

namespace equistream {
namespace {

constexpr std::array<char, 8> signature = {'\x89', 'P', 'N', 'G', '\r', '\n', '\x1a', '\n'};
constexpr std::size_t block_bytes = 1 << 16;

/// Reads on and keeps the checksum of what it read since the last restart.
class ChecksummedReader {
public:
    explicit ChecksummedReader(OIIO::Filesystem::IOProxy& file) : file_(file) {}

    bool read(void* to, std::size_t bytes) {
        if (file_.read(to, bytes) != bytes)
            return false;
        checksum_ = libdeflate_crc32(checksum_, to, bytes);
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
    OIIO::Filesystem::IOProxy& file_;
    std::vector<char> block_ = std::vector<char>(block_bytes);
    std::uint32_t checksum_ = 0;
};

}  // namespace

std::optional<std::string> png_damage(OIIO::Filesystem::IOProxy& file) {
    ChecksummedReader in(file);
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

}  // namespace equistream
