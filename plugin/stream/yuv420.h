#pragma once
/// 8-bit RGB <-> 8-bit Y'CbCr 4:2:0 (equistream/yuv.h), in fixed point within 1/100 of a step of the real-valued
/// formula. Rows run in parallel. Sides are even.
/// Down: weights 1 2 1 across and 1 1 down. Up: linear interpolation. The picture's border is repeated.
#include <equistream/yuv.h>

namespace equistream {

void rgb_to_yuv420(ImageView<const std::uint8_t> rgb, const Yuv420View<std::uint8_t>& yuv);
void yuv420_to_rgb(const Yuv420View<const std::uint8_t>& yuv, ImageView<std::uint8_t> rgb);

}  // namespace equistream
