#include "mask_bits.h"

namespace equistream {

MaskBits::MaskBits(const AlphaMask& mask)
    : mask_(mask), width_(mask.width), height_(mask.height), blocks_across_((static_cast<unsigned>(width_) + 7) / 8),
      repeats_(mask.wrap_u == Wrap::repeat && mask.wrap_v == Wrap::repeat) {
    if (!repeats_)
        return;
    blocks_.assign(std::size_t{blocks_across_} * ((static_cast<unsigned>(height_) + 7) / 8), 0);
    std::size_t texel = 0;
    for (unsigned y = 0; y < static_cast<unsigned>(height_); ++y)
        for (unsigned x = 0; x < static_cast<unsigned>(width_); ++x, ++texel)
            if (mask.opaque[texel] != 0)
                blocks_[(y >> 3) * blocks_across_ + (x >> 3)] |= std::uint64_t{1} << ((y & 7u) * 8 + (x & 7u));
}

}  // namespace equistream
