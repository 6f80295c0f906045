#pragma once
/// Gaps wide enough for a coarse picture to tell something of them.
#include <equistream_client/gaps.h>

namespace equistream {

/// Of gaps in a picture `width` pixels wide, those whose connected component, corners counted, holds a square of `side`
/// pixels a side. All of them for a side of 1.
Gaps wide_gaps(const Gaps& gaps, int width, int side);

}  // namespace equistream
