#pragma once
/// What main's colours cost and lose at the stream's settings, tried on a few frames.
#include "sources.h"

#include <equistream/stream.h>

#include <cstddef>
#include <optional>

namespace equistream {

/// The frames that are tried: the first few of the group of pictures in the middle.
struct TrialRange {
    TrialRange(std::size_t frames, int gop);
    std::size_t first = 0, last = 0;  ///< [first, last) among all frames
};

struct ColourTrial {
    double bytes = 0;  ///< a frame
    std::optional<CodingLoss> loss;
};

/// `settings` are the stream's, all but its tracks. Frames that cannot be used end the trial: coding them says why, and
/// keeps what came before. Without any it found nothing.
ColourTrial try_colour(const Sources& sources, const StreamSettings& settings);

}  // namespace equistream
