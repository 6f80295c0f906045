#include "recorded_file.h"

#include <equistream/error.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <limits>
#include <optional>
#include <vector>

namespace equistream::serve {

namespace {

constexpr std::uint64_t moov = 0x6d6f6f76, mdat = 0x6d646174;

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
    const auto given = std::max<std::int64_t>(count, 0);
    for (std::int64_t i = std::max<std::int64_t>(offset - hidden_at_, 0); i < hidden_bytes_; ++i)
        if (const std::int64_t at = hidden_at_ + i - offset; at < given)
            bytes[std::size_t(at)] = char(i == 0 ? 0xff >> (hidden_bytes_ - 1) : 0xff);
    return std::size_t(given);
}

bool RecordedFile::index_comes_last() const {
    constexpr int max_boxes = 4096;
    std::int64_t offset = 0;
    for (int box = 0; box < max_boxes; ++box) {
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

std::optional<SegmentSize> RecordedFile::segment() const {
    std::vector<char> head(matroska_head_bytes);
    head.resize(read(0, head));
    return segment_size(head);
}

std::vector<std::int64_t> RecordedFile::clusters(const std::function<bool()>& interrupted) const {
    std::vector<std::int64_t> found;
    const auto size = segment();
    for (std::int64_t offset = size ? size->offset + size->bytes : 0; size && !(interrupted && interrupted());) {
        std::array<char, ebml_head_bytes> head{};
        const auto element = ebml_element(std::span(head).first(read(offset, head)));
        if (!element)
            break;
        if (element->id == ebml_cluster)
            found.push_back(offset);
        offset += element->head_bytes + element->bytes;
    }
    return found;
}

bool RecordedFile::hide_segment_size() {
    const auto size = segment();
    if (!size)
        return false;
    hidden_at_ = size->offset;
    hidden_bytes_ = size->bytes;
    return true;
}

}  // namespace equistream::serve
