#pragma once
/// 8-bit RGB <-> 8-bit Y'CbCr 4:2:0, BT.709 matrix, limited range, left-sited chroma (on the even columns, between the
/// rows), in fixed point within 1/100 of a step of the real-valued formula. Rows run in parallel. Sides are even.
///     Y' = 16 + 219/255 (0.2126 R + 0.7152 G + 0.0722 B)
///     Cb = 128 + 224/255 (B - Y) / 1.8556        Cr = 128 + 224/255 (R - Y) / 1.5748
/// Down: weights 1 2 1 across and 1 1 down. Up: linear interpolation. The picture's border is repeated.
#include <equistream/image.h>

namespace equistream {

template <typename T>
struct Yuv420View {
    ImageView<T> y, cb, cr;  ///< one channel each; chroma planes have half the width and height
};

void rgb_to_yuv420(ImageView<const std::uint8_t> rgb, const Yuv420View<std::uint8_t>& yuv);
void yuv420_to_rgb(const Yuv420View<const std::uint8_t>& yuv, ImageView<std::uint8_t> rgb);

}  // namespace equistream
