#pragma once
/// What main's colours cost and lose at the stream's settings, tried on a few frames.
#include "sources.h"

#include <equistream/stream.h>

#include <cstddef>
#include <optional>

namespace equistream {

/// The frames that are tried: the first few of the group of pictures in the middle, or of one before it that has more.
struct TrialRange {
    TrialRange(std::size_t frames, int gop);
    std::size_t first = 0, last = 0;  ///< [first, last) among all frames
};

struct ColourTrial {
    int frames = 0;
    double bytes = 0;  ///< a frame
    std::optional<VisibleLoss> loss;
};

/// Made when it is first asked for. Borrows its arguments; `settings` are the stream's, all but its tracks.
class ColourTrials {
public:
    ColourTrials(const Sources& sources, const StreamSettings& settings) : sources_(sources), settings_(settings) {}

    /// Frames that cannot be used end the trial: coding them says why, and keeps what came before. Nothing without any.
    /// Throws WorkError where none can be made, for want of room for a scratch file, say.
    const ColourTrial& get();

private:
    const Sources& sources_;
    const StreamSettings& settings_;
    std::optional<ColourTrial> made_;
};

}  // namespace equistream
