#pragma once
/// The `pushpull` fill pass's filling of one picture. What it computes, level by level (pixels are level 0; a cell of
/// level l covers 2^l x 2^l pixels):
///
/// A pixel has one layer, a cell up to two, far and near. A layer has a mean w = B / (r - B) (depth_agreement.h) and is
/// *coloured* or *open*: open where all its pixels are gaps. Only pixels in or next to 8x8 tiles that hold a gap count;
/// all others are not there.
///   pull  The layers of a cell's four children are split half way between their least and largest w, unless these
///         differ by no more than e; the far half makes the cell's far layer, the other its near one: the mean of their
///         w, and the mean colour of those that are coloured.
///   push  From the top down, an open layer takes the colour of the coarser level's layers around it: bilinear, times
///         1 / (1 + (dw / e)^2), so that those at its own depth count before all others.
/// Gap pixels are the open layers of level 0.
#include "push_pull_pyramid.h"

#include "gaps.h"

#include <cstdint>

namespace equistream {

class PushPull {
public:
    /// Colours the gaps of the picture; returns how many (all, if anything is coloured at all). Keeps its memory for
    /// the next picture.
    std::int64_t run(const SurfaceDepths& depths, const Gaps& gaps, EyePicture& picture);

private:
    void find_tiles(const Gaps& gaps, int width, int height);
    void size_upper_levels();

    PullPyramid pyramid_;
};

}  // namespace equistream
