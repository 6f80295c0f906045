#pragma once
/// A recorded stream's file, open for reading. What of its container decides whether viewers can read it as it comes.
#include <plugin/stream/matroska_file.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace equistream::serve {

class RecordedFile {
public:
    /// Throws InputError for one that cannot be read.
    explicit RecordedFile(const std::string& file);
    ~RecordedFile();
    RecordedFile(const RecordedFile&) = delete;
    RecordedFile& operator=(const RecordedFile&) = delete;

    /// How many bytes from `offset` on it gave: 0 at its end, and where it cannot be read any more. Any thread.
    std::size_t read(std::int64_t offset, std::span<char> bytes) const;

    /// Of an MP4: whether the samples lie before the index (ISO 14496-12, 4.2). Viewers cannot go back.
    bool index_comes_last() const;
    /// Of Matroska: where its clusters begin (RFC 9559, 4.5), in their order. Each can follow any other. Looks no
    /// further than to an element whose size is not known, to what is no Matroska, and until `interrupted` returns
    /// true.
    std::vector<std::int64_t> clusters(const std::function<bool()>& interrupted = {}) const;
    /// Of Matroska: read() gives its segment's size as unknown (RFC 9559, 4.5). Readers would end there, and so such a
    /// file can follow another. False where it does not begin with its segment. Before anything is read.
    bool hide_segment_size();

private:
    std::optional<SegmentSize> segment() const;

    int file_;
    std::int64_t hidden_at_ = 0, hidden_bytes_ = 0;  ///< of that size
};

}  // namespace equistream::serve
