#pragma once
/// Frame data of a depth track's picture (FrameInfo::depth_code): the code of its samples and the range of its depths.
/// The codes themselves: depth_code.h.
#include <cstdint>

namespace equistream {

/// Values are part of the stream format; new ones are only appended.
enum class DepthCodeId : std::uint8_t { pece444 = 0, pece420 = 1, hue = 2, w8 = 3, w10 = 4, w12 = 5, lossless = 6 };

/// The depths that a code's samples span. All but `lossless` code the number x in [0, 1] with
///     x = w(r) / w(near) = (near - B) / (r - B)          w = B / (r - B)    (bound.h)
/// so 0 is infinity and 1 is `near_m`. Equal steps of x have equal bounds on the displacement, at every distance.
struct DepthRange {
    double box_radius_m = 0;  ///< B, above 0: radius of the head box around the picture's camera
    double near_m = 0;        ///< above box_radius_m; nearer depths are coded as this one
    /// Pixels may hold no surface (NaN). The w and Pece codes then reserve the topmost eighth of their samples for
    /// them.
    bool has_empty = false;

    bool operator==(const DepthRange&) const = default;
};

struct DepthCodeInfo {
    DepthCodeId code = DepthCodeId::w10;
    DepthRange range;
    std::uint32_t clamped_pixels = 0;  ///< coded samples of this picture that were nearer than near_m
    bool halved = false;               ///< coded at half the picture's columns and rows (depth_code.h)

    bool operator==(const DepthCodeInfo&) const = default;
};

}  // namespace equistream
