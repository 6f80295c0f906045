#pragma once
/// The loops of the `pushpull` pyramid, for every instruction set that Highway compiles them for; the one that this
/// processor has is picked when they run. Different tiles and spans may be worked on by different threads.
#include "push_pull_pyramid.h"

#include "gaps.h"

#include <cstdint>
#include <span>

namespace equistream {

/// Levels 1 to 3 of tiles `first` to before `last`.
void pull_tiles(PullPyramid& pyramid, std::size_t first, std::size_t last);
/// A dense level from the one below it, which is finished.
void pull_upper_level(PullPyramid& pyramid, int level);
/// Open layers of a dense level get colours of the level above.
void push_upper_level(PullPyramid& pyramid, int level);
/// The same of one level of the tiles that tiles_with_gaps has from `first` to before `last`.
void push_tiles(PullPyramid& pyramid, int level, std::size_t first, std::size_t last);
/// Gap pixels, from level 1; how many got a colour.
std::int64_t colour_spans(const PullPyramid& pyramid, std::span<const GapSpan> spans);

}  // namespace equistream
