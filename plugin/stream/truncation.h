#pragma once
/// One line on how a stream fell short, from what its tracks say of themselves.
#include "track_decoder.h"

#include <span>

namespace equistream {

struct SourceEnd {
    std::string source;
    std::string read_error;               ///< the demuxer's, empty at an ordinary end of file
    std::int64_t announced_pictures = 0;  ///< by a foreign file's header, of its first track; 0: not said
    std::int64_t missing_bytes = 0;       ///< of its end, by its header
};

/// Empty for a whole stream.
std::string describe_truncation(const SourceEnd& end, std::span<const TrackTally> tracks);

}  // namespace equistream
