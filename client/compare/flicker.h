#pragma once
/// What changes from one frame to the next beyond what motion explains. The error of that change is the flicker: an
/// error that stays on its surface counts nothing.
#include "compared_pictures.h"

#include <equistream/image.h>

namespace equistream {

/// How far, in pixels, the way to the frame before and back may miss a pixel that was seen there.
inline constexpr float max_return_px = 1;

/// Where each pixel's point was in the frame before, by the truth's motion planes. Where one of both frames has none,
/// every point is taken to stay in its pixel.
class PastPixels {
public:
    /// Both as read with their motion.
    PastPixels(const ScoredPicture& truth, const ScoredPicture& truth_before);

    bool by_motion() const { return !position_.empty(); }
    /// 255 where the point was in the picture before and nothing hid it; empty: everywhere.
    ImageView<const std::uint8_t> seen() const {
        return seen_.empty() ? ImageView<const std::uint8_t>{} : seen_.view();
    }
    /// A picture of this frame less what the one before shows of the same points, bilinearly; 0 where it shows nothing.
    FloatImage change(const FloatImage& now, const FloatImage& before) const;

private:
    Camera camera_;
    FloatImage position_;  ///< 2 channels, pixels of the frame before
    ByteImage seen_;
};

}  // namespace equistream
