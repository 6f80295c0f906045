#pragma once
/// Y'CbCr 4:2:0 of equistream's streams. 8 bits (10-bit HDR is below): ITU-R BT.709 matrix, limited range, left-sited
/// chroma (on the even columns, between the rows).
///     Y' = 16 + 219/255 Y        Y = kr R + kg G + kb B
///     Cb = 128 + 224/255 (B - Y) / cb_divisor        Cr = 128 + 224/255 (R - Y) / cr_divisor
/// with sRGB-encoded R, G, B and luma Y in 0 to 255. Views borrow their samples.
#include <equistream/image.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace equistream {

/// A picture's three planes, one channel each. The chroma planes have half the width and height.
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

/// Change of green per step of chroma, before division by chroma_scale.
inline constexpr double green_from_cb = -kb * cb_divisor / kg, green_from_cr = -kr * cr_divisor / kg;

}  // namespace bt709

/// Conversion to 8-bit R, G, B in fixed point, within 1/100 of a step of the real-valued formula. Chroma is
/// interpolated linearly, and the picture's border is repeated. All code computes these integers, also in vectors. So
/// sampling the planes and sampling their RGB give the same colours, bit for bit.
namespace yuv_to_rgb {

inline constexpr int fraction_bits = 16;
/// Interpolated chroma is in units of 1/8.
inline constexpr int tap_bits = 3;
inline constexpr int sum_bits = fraction_bits + tap_bits;

constexpr int fixed(double value) {
    const double scaled = value * (1 << fraction_bits);
    return static_cast<int>(scaled < 0 ? scaled - 0.5 : scaled + 0.5);
}

inline constexpr int luma_gain = fixed(1 / bt709::luma_scale) << tap_bits;
inline constexpr int red_from_cr = fixed(bt709::cr_divisor / bt709::chroma_scale);
inline constexpr int blue_from_cb = fixed(bt709::cb_divisor / bt709::chroma_scale);
inline constexpr int green_from_cb = fixed(bt709::green_from_cb / bt709::chroma_scale);
inline constexpr int green_from_cr = fixed(bt709::green_from_cr / bt709::chroma_scale);
/// Added to `luma_gain * luma`: the offset of black, and half a step for rounding.
inline constexpr int offset = -16 * luma_gain + (1 << (sum_bits - 1));

/// The chroma row with weight 1/4 for luma row y. Row y / 2 has weight 3/4.
inline int farther_row(int y, int chroma_height) {
    return std::clamp(y % 2 == 0 ? y / 2 - 1 : y / 2 + 1, 0, chroma_height - 1);
}

/// Chroma minus 128, in units of 1/8, at column x and row y of luma.
inline int chroma_eighths(const ImageView<const std::uint8_t>& plane, int x, int y) {
    const std::uint8_t* near_row = plane.row(y / 2);
    const std::uint8_t* far_row = plane.row(farther_row(y, plane.height));
    const int left = x / 2, right = std::min((x + 1) / 2, plane.width - 1);
    return 3 * (near_row[left] + near_row[right]) + far_row[left] + far_row[right] - 8 * 128;
}

using Rgb = std::array<std::uint8_t, 3>;

/// Colour of a luma sample with chroma_eighths.
inline Rgb rgb_of(int luma, int cb_eighths, int cr_eighths) {
    const auto byte = [](int sum) { return static_cast<std::uint8_t>(std::clamp(sum >> sum_bits, 0, 255)); };
    const int base = luma_gain * luma + offset;
    return {byte(base + red_from_cr * cr_eighths), byte(base + green_from_cb * cb_eighths + green_from_cr * cr_eighths),
            byte(base + blue_from_cb * cb_eighths)};
}

/// Colour at column x and row y of luma.
inline Rgb rgb_at(const YuvView& planes, int x, int y) {
    return rgb_of(planes.y.row(y)[x], chroma_eighths(planes.cb, x, y), chroma_eighths(planes.cr, x, y));
}

}  // namespace yuv_to_rgb

/// Converts a whole picture by yuv_to_rgb. `rgb` has luma's size, with 3 channels, or 4 of which the last becomes 255.
/// Width and height are even. Rows run in parallel.
void yuv420_to_rgb(const YuvView& yuv, ImageView<std::uint8_t> rgb);
/// Converts RGB, 3 channels, into the planes of `yuv`, in fixed point within 1/100 of a step. Chroma is averaged with
/// weights 1 2 1 across and 1 1 down, and the border is repeated. Width and height are even.
void rgb_to_yuv420(ImageView<const std::uint8_t> rgb, const Yuv420View<std::uint8_t>& yuv);

/// A decoder's own planes. They live, unchanged, while any copy of this object does.
template <typename T>
struct Yuv420Picture {
    Yuv420View<T> planes;
    std::shared_ptr<const void> owner;  ///< keeps the memory of `planes`

    bool empty() const { return planes.empty(); }
};

using YuvPicture = Yuv420Picture<const std::uint8_t>;

// 10-bit Y'CbCr 4:2:0 of HDR streams: R'G'B' of SMPTE ST 2084 (PQ) with BT.2020 primaries, BT.2020 non-constant
// luminance matrix, limited range, chroma sited and resampled as above.
//     Y' = 64 + 876 Y        Y = kr R' + kg G' + kb B'
//     Cb = 512 + 896 (B' - Y) / cb_divisor           Cr = 512 + 896 (R' - Y) / cr_divisor
// with R', G', B' and luma Y in 0 to 1.

using PqView = Yuv420View<const std::uint16_t>;  ///< 10-bit samples, 0 to 1023
using PqPicture = Yuv420Picture<const std::uint16_t>;

namespace bt2020 {

inline constexpr double kr = 0.2627, kb = 0.0593, kg = 1 - kr - kb;
inline constexpr double luma_black = 64, luma_scale = 876, chroma_middle = 512, chroma_scale = 896;
inline constexpr double cb_divisor = 2 * (1 - kb), cr_divisor = 2 * (1 - kr);
inline constexpr double green_from_cb = -kb * cb_divisor / kg, green_from_cr = -kr * cr_divisor / kg;

}  // namespace bt2020

/// Converts to R'G'B', 3 channels, clamped to 0 to 1. Chroma is interpolated linearly, and the border is repeated. Rows
/// run in parallel.
FloatImage pq_to_rgb(const PqView& planes);
/// Converts R'G'B', 3 channels from 0 to 1, into `planes`. Chroma is averaged with weights 1 2 1 across and 1 1 down.
/// Width and height are even.
void rgb_to_pq(ImageView<const float> rgb, const Yuv420View<std::uint16_t>& planes);

/// Memory that the user of pictures supplies to the decoder, such as a GPU driver's buffers, so that no copy is needed.
class PictureMemory {
public:
    virtual ~PictureMemory() = default;

    /// A block of at least `bytes`, aligned to 64 bytes, which belongs to the caller until the last copy of the pointer
    /// is gone. null: no block is free, and the decoder uses its own memory. Decoders also read what they have written
    /// there. Called by any number of threads at once; does not wait.
    virtual std::shared_ptr<std::uint8_t> take(std::size_t bytes) = 0;
};

}  // namespace equistream
