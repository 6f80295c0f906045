#pragma once
/// 8-bit RGB to 8-bit Y'CbCr 4:2:0 (equistream/yuv.h has the way back), in fixed point within 1/100 of a step of the
/// real-valued formula. Rows run in parallel. Sides are even.
/// Weights 1 2 1 across and 1 1 down. The picture's border is repeated.
#include <equistream/yuv.h>

namespace equistream {

void rgb_to_yuv420(ImageView<const std::uint8_t> rgb, const Yuv420View<std::uint8_t>& yuv);

}  // namespace equistream
