#include "matroska_file.h"

#include <algorithm>
#include <bit>
#include <filesystem>
#include <fstream>
#include <vector>

namespace equistream {

namespace {

constexpr std::uint64_t ebml_id = 0x1a45dfa3, segment_id = 0x18538067;
constexpr std::size_t id_bytes = 4;
constexpr std::int64_t max_header_bytes = 1 << 16;

/// Nothing where the head ends before.
std::optional<std::uint64_t> number_at(std::span<const char> head, std::int64_t offset, std::size_t count) {
    const auto begin = static_cast<std::size_t>(offset);
    if (begin > head.size() || count > head.size() - begin)
        return std::nullopt;
    std::uint64_t value = 0;
    for (const char byte : head.subspan(begin, count))
        value = value << 8 | static_cast<std::uint8_t>(byte);
    return value;
}

/// In as many bytes as the first one says. All ones: unknown.
std::optional<SegmentSize> size_at(std::span<const char> head, std::int64_t offset) {
    const auto first = number_at(head, offset, 1);
    const int count = first ? std::countl_zero(static_cast<std::uint8_t>(*first)) + 1 : 9;
    const auto all = count > 8 ? std::nullopt : number_at(head, offset, static_cast<std::size_t>(count));
    if (!all)
        return std::nullopt;
    const std::uint64_t ones = (std::uint64_t{1} << 7 * count) - 1, value = *all & ones;
    SegmentSize size{offset, count};
    if (value != ones)
        size.value = static_cast<std::int64_t>(value);
    return size;
}

std::vector<char> first_bytes(const std::string& file, std::size_t count) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(file, error))
        return {};
    std::vector<char> bytes(count);
    std::ifstream in(file, std::ios::binary);
    in.read(bytes.data(), static_cast<std::streamsize>(count));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
    return bytes;
}

}  // namespace

std::optional<SegmentSize> segment_size(std::span<const char> head) {
    const auto header = number_at(head, 0, id_bytes) == ebml_id ? size_at(head, id_bytes) : std::nullopt;
    if (!header || !header->value || *header->value > max_header_bytes)
        return std::nullopt;
    const std::int64_t behind = header->offset + header->bytes + *header->value;
    if (number_at(head, behind, id_bytes) != segment_id)
        return std::nullopt;
    return size_at(head, behind + std::int64_t{id_bytes});
}

std::optional<EbmlElement> ebml_element(std::span<const char> head) {
    const auto first = number_at(head, 0, 1);
    const int count = first ? std::countl_zero(static_cast<std::uint8_t>(*first)) + 1 : 9;
    const auto id = count > int{id_bytes} ? std::nullopt : number_at(head, 0, static_cast<std::size_t>(count));
    const auto size = id ? size_at(head, count) : std::nullopt;
    if (!size || !size->value)
        return std::nullopt;
    return EbmlElement{static_cast<std::uint32_t>(*id), size->offset + size->bytes, *size->value};
}

bool is_matroska(const std::string& file) {
    return number_at(first_bytes(file, id_bytes), 0, id_bytes) == ebml_id;
}

std::int64_t missing_matroska_bytes(const std::string& file) {
    const auto size = segment_size(first_bytes(file, matroska_head_bytes));
    if (!size || !size->value)
        return 0;
    std::error_code error;
    const auto file_bytes = static_cast<std::int64_t>(std::filesystem::file_size(file, error));
    return error ? 0 : std::max<std::int64_t>(0, size->offset + size->bytes + *size->value - file_bytes);
}

}  // namespace equistream
