#pragma once
/// What libav keeps to itself of a Matroska file.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace equistream {

/// Where the segment, which all but a file's head is in, says its own size (RFC 8794, 4).
struct SegmentSize {
    std::int64_t offset = 0, bytes = 0;   ///< of that number in the file
    std::optional<std::int64_t> value{};  ///< from behind it on; nothing: unknown
};

/// So many bytes at its start are looked at.
inline constexpr std::size_t matroska_head_bytes = (std::size_t{1} << 16) + 32;

/// `head` is a file's start. Nothing where that is no Matroska, has a head longer than 64 KiB or ends before.
std::optional<SegmentSize> segment_size(std::span<const char> head);

/// By its first bytes; false for what is no regular file.
bool is_matroska(const std::string& file);

/// How many bytes of its end a file lacks. 0 where its segment's size is not known, and for whatever is no Matroska.
std::int64_t missing_matroska_bytes(const std::string& file);

}  // namespace equistream
