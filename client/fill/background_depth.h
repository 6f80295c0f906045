#pragma once
/// How far away the background of a gap is, where nobody knows what its pixels see. What a source did not see lies
/// behind the edge of something that it saw; moving from the source to the eye lays the gap open between that edge and
/// the background, along the eye's epipolar lines.
#include "gaps.h"

#include <client/warp/view.h>

namespace equistream {

/// Gives each gap pixel of `background_m` (the picture's size) the larger of the depths at the two ends of its run
/// along its row or its column, whichever is nearer to its epipolar line; NaN where the run ends at the picture's
/// borders only. `epipole`: the source's position from the eye, in the eye's axes; 0: the largest of all four ends.
void find_background(const EyeView& eye, const EyePicture& picture, const Gaps& gaps, const glm::dvec3& epipole,
                     FloatImage& background_m);

}  // namespace equistream
