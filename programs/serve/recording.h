#pragma once
/// A recorded stream that is open for all viewers, each of which gets it from its beginning.
#include "feed.h"

#include <equistream/send_times.h>

#include <cstdint>

namespace equistream::serve {

class Recording : public Programme {
public:
    /// `loop`: over and over. Throws InputError for what cannot be read or is no video with times.
    Recording(const std::string& file, bool loop);
    ~Recording() override;
    Recording(const Recording&) = delete;
    Recording& operator=(const Recording&) = delete;

    std::unique_ptr<Feed> open_feed() override;

    std::int64_t bytes() const { return times_.parts.back().end; }
    double duration_s() const { return times_.duration_s; }
    bool is_matroska() const { return times_.is_matroska; }
    bool loops() const { return loop_; }
    /// Where the bytes end that are due at this time.
    std::int64_t due_at(double time_s) const;
    /// When the byte at this offset, of those there are, is due.
    double time_of(std::int64_t offset) const;
    /// How many bytes from this offset on it has put into `bytes`; none where the file has become shorter or cannot
    /// be read any more.
    std::size_t read(std::int64_t offset, std::span<char> bytes) const;

private:
    SendTimes times_;
    bool loop_;
    int file_ = -1;
};

}  // namespace equistream::serve
