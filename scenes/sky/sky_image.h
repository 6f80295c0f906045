#pragma once
/// Reading a sky's image.
#include <equistream/image.h>

#include <filesystem>

namespace equistream {

/// The largest sky: 16,384 x 8,192 pixels (2.5 GiB while it is in use).
inline constexpr std::int64_t max_sky_pixels = std::int64_t{1} << 27;

/// RGB of a file that holds radiance as floating-point numbers (OpenEXR, Radiance HDR, whatever else OpenImageIO reads
/// as such), grey repeated, in linear Rec.709: converted where the file names other primaries. InputError names the
/// file if it cannot be read, is no lat-long image or too large, or holds a pixel that is not finite or negative.
FloatImage read_sky_image(const std::filesystem::path& file);

}  // namespace equistream
