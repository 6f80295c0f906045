#pragma once
/// Pixels that nobody looks at, coloured so that a picture codes well.
#include <equistream/image.h>

namespace equistream {

/// Where `known` is 0: colour from the nearest known pixels, ever smoother with the distance to them (averages over
/// 2x2 blocks, again and again, put back where there was nothing), and alpha 0. `closes`: the last column is beside the
/// first. RGBA; `known` is one channel of the same size. All 0 where nothing is known.
void pad_colour(FloatImage& rgba, const ByteImage& known, bool closes);

}  // namespace equistream
