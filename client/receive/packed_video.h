#pragma once
/// Other people's stereo video, which has both eyes in each picture.
#include <equistream/stream.h>

namespace equistream {

/// Leaves the left eye's half of what `packing` (not none) has both eyes in, the upper one or the left one, and gives
/// the right eye's. Planes are not copied.
DecodedPicture split_eyes(DecodedPicture& picture, StereoPacking packing);

}  // namespace equistream
