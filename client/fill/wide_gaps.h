#pragma once
/// Gaps wide enough for a coarse picture to tell something of them.
#include "gaps.h"

#include <equistream/camera.h>

namespace equistream {

/// Of gaps in a picture `width` pixels wide, those whose connected component, corners counted, holds a square of `side`
/// pixels a side. All of them for a side of 1.
Gaps wide_gaps(const Gaps& gaps, int width, int side);

/// Which squares are wide enough for a source: half of its pixel, in the eye's, where both look straight ahead. By
/// trial: in gaps of less, colours of full resolution around them are mostly nearer the truth (docs/decisions/0004).
int wide_gap_side(const PerspectiveCamera& eye, const Camera& source);

}  // namespace equistream
