#pragma once
/// What a failed comparison of pictures leaves behind: image, reference and difference as PNGs, and where they are.
///
///     EXPECT_LT(worst, bound) << evidence(picture.rgb.view(), exact.view());
///
/// GoogleTest evaluates what stands behind << only where an expectation has failed.
#include <equistream/image.h>

#include <cstdint>
#include <string>

namespace equistream::test {

/// Writes failed-pictures/TEST.N.{image,reference,difference}.png below the working folder and returns a line that says
/// so. 1 or 3 channels of one size, in [0, 1]; what goes beyond, as depth does, is scaled down, in both alike; +inf is
/// white, NaN black. The difference is scaled so that the largest is white; finite against not finite is white too.
std::string evidence(ImageView<const float> image, ImageView<const float> reference);
std::string evidence(ImageView<const std::uint8_t> image, ImageView<const std::uint8_t> reference);

}  // namespace equistream::test
