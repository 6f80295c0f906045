#pragma once
/// Where to begin decoding so that a moment can be shown: the packets from there on.
#include "libav.h"

#include <deque>
#include <optional>
#include <span>

namespace equistream {

/// Of these streams, the first of which decides what is near, all packets in the order they lie in from each one's last
/// key frame on that is shown at `time_s` or before, as far as the search had to read; what follows comes next from
/// `format`. Nothing where that cannot be told (no times, no way back): `format` is anywhere then.
std::optional<std::deque<av::Packet>> find_packets(AVFormatContext& format, std::span<const int> streams,
                                                   double time_s);

}  // namespace equistream
