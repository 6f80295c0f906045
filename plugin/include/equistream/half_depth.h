#pragma once
/// Radial depth at half the columns and half the rows, for tracks that get few bits. No depth is ever made up: each
/// sample is one of those that it stands for. Depths are 1 channel, NaN where there is no surface; sides are even.
/// Functions are pure; rows run in parallel.
#include <equistream/image.h>

namespace equistream {

/// The nearest of each four, NaN where none of them is a surface. What stands before something else keeps its outline
/// and its thin parts, at most a pixel too wide; the farthest or the first would lose them.
FloatImage halve_depth(ImageView<const float> depth_m);

/// Each sample four times. As good as it gets without the colour; with it: guided_depth.h of the client's.
FloatImage double_depth(ImageView<const float> half_m);

}  // namespace equistream
