#pragma once
/// An AlphaMask at one bit a texel, 8 x 8 texels to a word: all masks of a scene full of leaves stay in the cache,
/// where the bytes of AlphaMask would not. Internal to Bvh.
#include <scenes/library/model.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace equistream {

class MaskBits {
public:
    explicit MaskBits(const AlphaMask& mask);

    /// The same as mask.covers(uv); repeating masks, nearly all there are, are answered from the bits.
    bool covers(const glm::vec2& uv) const {
        if (!repeats_)
            return mask_.covers(uv);
        const auto x = static_cast<unsigned>(repeated(uv.x, width_));
        const auto y = static_cast<unsigned>(repeated(uv.y, height_));
        return blocks_[(y >> 3) * blocks_across_ + (x >> 3)] >> ((y & 7u) * 8 + (x & 7u)) & 1u;
    }

private:
    static int repeated(float coordinate, int size) {
        if (!(std::abs(coordinate) < 1e6f))
            return 0;
        float part = coordinate - static_cast<float>(static_cast<int>(coordinate));
        part += part < 0 ? 1.0f : 0.0f;
        return std::min(static_cast<int>(part * static_cast<float>(size)), size - 1);
    }

    const AlphaMask& mask_;
    int width_, height_;
    unsigned blocks_across_;
    bool repeats_;
    std::vector<std::uint64_t> blocks_;
};

}  // namespace equistream
