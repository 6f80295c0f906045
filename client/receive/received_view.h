#pragma once
/// A received picture as engines and fill passes take it. What comes out borrows the picture's pixels. Pure functions.
#include "receive.h"

#include <client/warp/view.h>

namespace equistream {

/// Of the head box around the picture's centre (bound.h), metres.
double head_box_radius(const FrameInfo& info);

/// `depth_m` as in SourceView; empty: not known.
SourceView source_view(const ReceivedPicture& picture, const FloatImage& depth_m);

}  // namespace equistream
