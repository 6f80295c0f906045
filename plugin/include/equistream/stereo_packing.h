#pragma once
/// Both eyes in one picture, as ordinary players and displays take them: one definition for what is encoded, played and
/// viewed. Pictures are 8-bit RGB; a pure function.
#include <equistream/image.h>
#include <equistream/stream.h>

namespace equistream {

/// The left eye's picture above, or to the left of, the right one's, of one size. `packing` is not none.
ByteImage packed_eyes(StereoPacking packing, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);

}  // namespace equistream
