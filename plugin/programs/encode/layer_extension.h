#pragma once
/// What a codec is given where a hidden layer holds nothing. A layer is islands in a void; coded as black and "no
/// surface" the islands' outlines cost more bits than all that is in them. So colours and depths are carried on
/// smoothly, as the pyramid of Gortler et al., The Lumigraph (1996), does: what an eye finds there by chance is what
/// push-pull would have put there.
#include <equistream/image.h>

namespace equistream {

/// Replaces every sample for which `there` (1 channel, of the same size) is 0, from those where it is not; these stay
/// as they are. Values stay between the least and the largest that are there. Nothing there: all stays as it is.
void extend(FloatImage& samples, ImageView<const std::uint8_t> there);

/// NaN becomes depth, smooth in w = B / (r - B) (equistream/bound.h), in which codes count their steps.
void extend_depth(FloatImage& depth_m, double box_radius_m);
/// Colours of pixels without depth (NaN in `depth_m`, of the same size).
void extend_colour(ByteImage& rgb, ImageView<const float> depth_m);

}  // namespace equistream
