#pragma once
/// Rendered frames as EXR files that compositing programs read: deep, or in parts. Files appear whole or not at all.
#include <equistream/frame.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace equistream::compositing {

/// Where the sky lies in a deep picture, metres: compositing programs take no infinity.
inline constexpr float sky_m = 1e10f;

/// One eye's pictures of one frame, and the file that its attributes come from.
struct View {
    std::string name;  ///< "centre", "left" or "right"
    std::filesystem::path file;
    Frame front;                  ///< planes colour and, where there is one, depth
    std::optional<Frame> hidden;  ///< the surface behind it, of the same size: colour and depth
};

/// Samples of a deep picture.
struct DeepCounts {
    std::int64_t front = 0, hidden = 0;
    std::int64_t left_out = 0;  ///< of the hidden layer, not behind the front
};

/// Channels R, G, B, A (half) and Z, ZBack (float, metres along the pixel's ray, equal: surfaces). Each pixel has its
/// front surface and, behind it, its hidden one; all are opaque, so that flattened it is the front picture. `view` has
/// depth.
DeepCounts write_deep(const std::filesystem::path& file, const View& view);

/// Parts rgba (R, G, B, A), depth (Z) and hidden (hidden.R .G .B .A .Z) of each view. With several views parts are
/// called rgba.left and so on. Pixels without a hidden surface are 0 and have an infinite hidden.Z there.
void write_parts(const std::filesystem::path& file, const std::vector<View>& views);

}  // namespace equistream::compositing
