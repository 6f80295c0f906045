#include <equistream/stream.h>

#include <algorithm>
#include <cassert>

namespace equistream {

ByteImage packed_eyes(StereoPacking packing, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
    assert(packing != StereoPacking::none && left.width == right.width && left.height == right.height);
    const bool beside = packing == StereoPacking::side_by_side;
    ByteImage both(beside ? 2 * left.width : left.width, beside ? left.height : 2 * left.height, 3);
    for (int y = 0; y < left.height; ++y) {
        std::copy_n(left.row(y), 3 * left.width, both.pixel(0, y));
        std::copy_n(right.row(y), 3 * left.width, beside ? both.pixel(left.width, y) : both.pixel(0, left.height + y));
    }
    return both;
}

}  // namespace equistream
