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

/// An element of EBML (RFC 8794, 5), at the start of `head`. Nothing where that is none, ends before, or has a size
/// that is not known.
struct EbmlElement {
    std::uint32_t id = 0;
    std::int64_t head_bytes = 0, bytes = 0;  ///< before its content, and of that
};
inline constexpr std::size_t ebml_head_bytes = 12;
std::optional<EbmlElement> ebml_element(std::span<const char> head);
inline constexpr std::uint32_t ebml_cluster = 0x1f43b675;

/// By its first bytes; false for what is no regular file.
bool is_matroska(const std::string& file);

/// How many bytes of its end a file lacks. 0 where its segment's size is not known, and for whatever is no Matroska.
std::int64_t missing_matroska_bytes(const std::string& file);

}  // namespace equistream
