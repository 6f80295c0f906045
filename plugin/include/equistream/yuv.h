#pragma once
/// 8-bit Y'CbCr 4:2:0 as our streams carry it: BT.709 matrix, limited range, left-sited chroma (on the even columns,
/// between the rows).
///     Y' = 16 + 219/255 (kr R + kg G + kb B)
///     Cb = 128 + 224/255 (B - Y) / cb_divisor        Cr = 128 + 224/255 (R - Y) / cr_divisor
/// with R, G, B, Y in 0 to 255. Views borrow their samples.
#include <equistream/image.h>

#include <cstdint>

namespace equistream {

/// A picture's three planes, one channel each; those of chroma have half the width and height.
template <typename T>
struct Yuv420View {
    ImageView<T> y, cb, cr;

    bool empty() const { return y.data == nullptr; }
};

using YuvView = Yuv420View<const std::uint8_t>;

namespace bt709 {

inline constexpr double kr = 0.2126, kb = 0.0722, kg = 1 - kr - kb;
inline constexpr double luma_scale = 219.0 / 255, chroma_scale = 224.0 / 255;
inline constexpr double cb_divisor = 2 * (1 - kb), cr_divisor = 2 * (1 - kr);

/// What a step of chroma adds to green, before chroma_scale is divided out.
inline constexpr double green_from_cb = -kb * cb_divisor / kg, green_from_cr = -kr * cr_divisor / kg;

}  // namespace bt709

}  // namespace equistream
