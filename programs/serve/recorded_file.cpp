#include "recorded_file.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <limits>
#include <optional>

namespace equistream::serve {

namespace {

constexpr std::uint64_t moov = 0x6d6f6f76, mdat = 0x6d646174, ebml = 0x1a45dfa3, segment = 0x18538067;

/// So many bytes as a number; nothing where the file ends before.
std::optional<std::uint64_t> number_at(const RecordedFile& file, std::int64_t offset, std::size_t count) {
    std::array<char, 8> bytes{};
    if (file.read(offset, std::span(bytes).first(count)) < count)
        return std::nullopt;
    std::uint64_t value = 0;
    for (const char byte : std::span(bytes).first(count))
        value = value << 8 | static_cast<std::uint8_t>(byte);
    return value;
}

/// RFC 8794, 4: a number, in as many bytes as the first says. All ones: unknown.
struct DataSize {
    std::int64_t value = 0, bytes = 0;
    bool is_unknown = false;
};

std::optional<DataSize> data_size_at(const RecordedFile& file, std::int64_t offset) {
    const auto first = number_at(file, offset, 1);
    const int count = first ? std::countl_zero(static_cast<std::uint8_t>(*first)) + 1 : 9;
    const auto all = count > 8 ? std::nullopt : number_at(file, offset, std::size_t(count));
    if (!all)
        return std::nullopt;
    const std::uint64_t ones = (std::uint64_t{1} << 7 * count) - 1;
    return DataSize{std::int64_t(*all & ones), count, (*all & ones) == ones};
}

}  // namespace

RecordedFile::RecordedFile(const std::string& file) : file_(open(file.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (file_ < 0)
        throw InputError(expected_found(file, "a file that can be read", std::strerror(errno)));
}

RecordedFile::~RecordedFile() {
    close(file_);
}

std::size_t RecordedFile::read(std::int64_t offset, std::span<char> bytes) const {
    ssize_t count = 0;
    do
        count = pread(file_, bytes.data(), bytes.size(), offset);
    while (count < 0 && errno == EINTR);
    return std::size_t(std::max<ssize_t>(count, 0));
}

bool RecordedFile::index_comes_last() const {
    constexpr int most_boxes = 4096;
    std::int64_t offset = 0;
    for (int box = 0; box < most_boxes; ++box) {
        const auto said = number_at(*this, offset, 4), kind = number_at(*this, offset + 4, 4);
        const auto size = said == 1 ? number_at(*this, offset + 8, 8) : said;
        if (!kind || !size || *kind == moov)
            return false;
        if (*kind == mdat)
            return true;
        if (*size < 8 || *size > std::uint64_t(std::numeric_limits<std::int64_t>::max() / 2 - offset))
            return false;
        offset += std::int64_t(*size);
    }
    return false;
}

bool RecordedFile::says_its_size() const {
    constexpr std::int64_t longest_header = 1 << 16;
    const auto header = number_at(*this, 0, 4) == ebml ? data_size_at(*this, 4) : std::nullopt;
    if (!header || header->value > longest_header)
        return true;
    const std::int64_t behind = 4 + header->bytes + header->value;
    const auto size = number_at(*this, behind, 4) == segment ? data_size_at(*this, behind + 4) : std::nullopt;
    return !size || !size->is_unknown;
}

}  // namespace equistream::serve
