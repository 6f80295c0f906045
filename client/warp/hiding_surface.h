#pragma once
/// Where a smooth surface of the source's hides a point though one of the samples around lies at the point's depth.
///
/// On a surface that runs steeply through four samples their depths spread so far that one of them often agrees by
/// chance with a point behind it. Samples alone do not tell: w = B / (r - B) of a smooth surface is known between them
/// too. Where the sixteen samples around a position bend little, in all second differences (along every row and column,
/// and across the inner four), bilinear w is off by at most k s(1 - s) along an axis, s being the fraction between the
/// inner samples and k the sum of both second differences there: so much where the surface has one crease between them,
/// a quarter of it where it is round. A point whose w is smaller by more than that, along both axes, and min_behind
/// budgets is hidden. Steps, edges and what is unknown bend more and say nothing; a point before the surface cannot be
/// hidden by it.
#include "warp.h"

#include <equistream/depth_agreement.h>

#include <array>

namespace equistream {

using formulas::max_bend;
using formulas::min_behind;

/// Of sixteen samples around a position, row by row, the inner four around it. `over_clearance`: 1 / (r - B) of each, w
/// over B, NaN where nothing is known; `s` and `t` in [0, 1) between the inner columns and rows.
bool surface_hides(const DepthAgreement& agreement, const std::array<float, 16>& over_clearance, float s, float t,
                   float point_over_clearance);

/// The same of a point at a position of a source; `u` and `v` in 1/128 of a sample from the centre of its first.
bool surface_hides(const DepthAgreement& agreement, const SourceGrid& grid, const ImageView<const float>& depth_m,
                   int u, int v, float point_over_clearance);

}  // namespace equistream
