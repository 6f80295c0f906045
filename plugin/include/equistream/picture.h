#pragma once
/// Display-referred 8-bit pictures on disk (PNG), and pictures of what cannot be seen: depth, motion, normals, ids.
/// Errors name the file: InputError for what cannot be read, WorkError for what cannot be written.
#include <equistream/colour.h>
#include <equistream/frame.h>

#include <filesystem>
#include <string>

namespace equistream {

/// Reads any 8-bit picture OpenImageIO knows as 1 or 3 channels (alpha is dropped). Sizes are checked before
/// allocating.
ByteImage read_picture(const std::filesystem::path& file);

/// Writes 1, 3 or 4 channels as the extension says, aside and then renamed.
void write_picture(const std::filesystem::path& file, ImageView<const std::uint8_t> picture);

/// A false-colour picture of one plane of a frame, by what the plane means:
///   colour, albedo         the display transform
///   depth, virtual_depth   near warm, far cold, by w = B / (r - B) on a log scale; misses and what is not there black
///   motion, also virtual   hue = direction, brightness = length
///   normal                 (n + 1) / 2               ids   one colour an id
/// Throws InputError for a plane the frame does not have.
ByteImage picture_of_plane(const Frame& frame, const std::string& plane, const DisplayTransform& display);

}  // namespace equistream
