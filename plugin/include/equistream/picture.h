#pragma once
/// Display-referred 8-bit pictures on disk (PNG), and false-colour pictures of depth, motion, normals and ids.
/// Errors name the file: InputError for what cannot be read, WorkError for what cannot be written.
#include <equistream/colour.h>
#include <equistream/frame.h>

#include <filesystem>
#include <string>

namespace equistream {

/// Reads a picture of any format that OpenImageIO knows, as 8-bit samples with 1 or 3 channels; alpha is dropped. Sizes
/// are checked against image.h's limits before anything is allocated.
ByteImage read_picture(const std::filesystem::path& file);

/// Writes 1, 3 or 4 channels of sRGB values in the format of the extension. The file appears whole or not at all.
void write_picture(const std::filesystem::path& file, ImageView<const std::uint8_t> picture);

/// A picture of one plane of a frame, by what the plane means:
///   colour, albedo         the display transform
///   depth, virtual_depth   near warm, far cold: log w, w = B / (r - B), between its 0.5 % and 99.5 % quantiles
///   motion, also virtual   hue = direction, brightness = length
///   normal                 (n + 1) / 2
///   ids, cryptomatte       one colour for each id
///   specular               white where it is 1
/// Misses and pixels without a surface are black in depth. Throws InputError for a plane that the frame does not have.
ByteImage picture_of_plane(const Frame& frame, const std::string& plane, const DisplayTransform& display);

}  // namespace equistream
