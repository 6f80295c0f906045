#pragma once
/// 10-bit Y'CbCr 4:2:0 of HDR streams: R'G'B' of SMPTE ST 2084 (PQ) with BT.2020 primaries, BT.2020 non-constant
/// luminance matrix, limited range, chroma sited and resampled as in yuv.h.
///     Y' = 64 + 876 (kr R' + kg G' + kb B')
///     Cb = 512 + 896 (B' - Y) / cb_divisor           Cr = 512 + 896 (R' - Y) / cr_divisor
/// with R', G', B', Y in 0 to 1.
#include <equistream/yuv.h>

#include <memory>

namespace equistream {

using PqView = Yuv420View<const std::uint16_t>;  ///< samples of 10 bits

/// A decoder's own planes, as YuvPicture holds those of 8 bits.
struct PqPicture {
    PqView planes;
    std::shared_ptr<const void> owner;

    bool empty() const { return planes.empty(); }
};

namespace bt2020 {

inline constexpr double kr = 0.2627, kb = 0.0593, kg = 1 - kr - kb;
inline constexpr double luma_black = 64, luma_scale = 876, chroma_middle = 512, chroma_scale = 896;
inline constexpr double cb_divisor = 2 * (1 - kb), cr_divisor = 2 * (1 - kr);
inline constexpr double green_from_cb = -kb * cb_divisor / kg, green_from_cr = -kr * cr_divisor / kg;

}  // namespace bt2020

/// R'G'B', 3 channels, clamped to 0 to 1; chroma interpolated linearly, the border repeated. Rows run in parallel.
FloatImage pq_to_rgb(const PqView& planes);
/// The way there, of 3 channels: chroma averaged with weights 1 2 1 across and 1 1 down.
void rgb_to_pq(ImageView<const float> rgb, const Yuv420View<std::uint16_t>& planes);

}  // namespace equistream
