#pragma once
/// What a picture of a depth track says of itself (FrameInfo::depth_code): which code its samples are and for which
/// depths. The codes themselves: depth_code.h.
#include <cstdint>

namespace equistream {

/// Values are part of the stream format; new ones are only appended.
enum class DepthCodeId : std::uint8_t { pece444 = 0, pece420 = 1, hue = 2, w8 = 3, w10 = 4, w12 = 5, lossless = 6 };

/// The depths that a code's samples span. All but `lossless` code the number x in [0, 1] with
///     x = w(r) / w(near) = (near - B) / (r - B)          w = B / (r - B)    (bound.h)
/// so 0 is infinity and 1 is `near_m`, and equal steps of x displace a point by equal angles at most, wherever it is.
struct DepthRange {
    double box_radius_m = 0;  ///< B, above 0: of the head box around the picture's centre
    double near_m = 0;        ///< above box_radius_m; nearer depths are coded as this one
    bool has_empty = false;   ///< the topmost eighth of the samples is kept for pixels that hold no surface (NaN)

    bool operator==(const DepthRange&) const = default;
};

struct DepthCodeInfo {
    DepthCodeId code = DepthCodeId::w10;
    DepthRange range;
    std::uint32_t clamped_pixels = 0;  ///< how many of this picture's coded samples lay nearer than near_m
    bool halved = false;               ///< coded at half the picture's columns and rows (depth_code.h)

    bool operator==(const DepthCodeInfo&) const = default;
};

}  // namespace equistream
