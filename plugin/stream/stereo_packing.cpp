#include <equistream/stream.h>

#include <algorithm>
#include <cassert>

namespace equistream {

namespace {

template <typename T>
Image<T> packed(StereoPacking packing, ImageView<const T> left, ImageView<const T> right) {
    assert(packing != StereoPacking::none && left.width == right.width && left.height == right.height &&
           left.channels == right.channels);
    const bool beside = packing == StereoPacking::side_by_side;
    Image<T> both(beside ? 2 * left.width : left.width, beside ? left.height : 2 * left.height, left.channels);
    const auto samples = std::ptrdiff_t(left.channels) * left.width;
    for (int y = 0; y < left.height; ++y) {
        std::copy_n(left.row(y), samples, both.pixel(0, y));
        std::copy_n(right.row(y), samples, beside ? both.pixel(left.width, y) : both.pixel(0, left.height + y));
    }
    return both;
}

}  // namespace

ByteImage packed_eyes(StereoPacking packing, ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
    return packed(packing, left, right);
}

FloatImage packed_eyes(StereoPacking packing, ImageView<const float> left_m, ImageView<const float> right_m) {
    return packed(packing, left_m, right_m);
}

}  // namespace equistream
