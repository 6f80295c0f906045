// Vectors that the loops of resample.h are made of: up to 16 pixels at once. Included once for each instruction set.
#if defined(EQUISTREAM_WARP_NUMBERS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_WARP_NUMBERS_INL_H
#undef EQUISTREAM_WARP_NUMBERS_INL_H
#else
#define EQUISTREAM_WARP_NUMBERS_INL_H
#endif

#include "resample.h"

#include <hwy/cache_control.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::CappedTag<float, tile_width>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using FloatMask = hn::Mask<FloatTag>;
using IntMask = hn::Mask<IntTag>;

constexpr FloatTag float_tag;
constexpr IntTag int_tag;
constexpr int lanes = int(hn::MaxLanes(FloatTag()));

HWY_INLINE Floats all(float value) {
    return hn::Set(float_tag, value);
}
HWY_INLINE Ints all(int value) {
    return hn::Set(int_tag, value);
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#include <plugin/formulas/vectors-inl.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::HWY_NAMESPACE {

struct Vectors {
    Floats x, y, z;
};

HWY_INLINE Floats dot(const Vectors& a, const Vectors& b) {
    return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, a.z * b.z));
}

/// What tiles to the right will read of a plane, from where this one's rows end, is asked for now: the lower samples,
/// as the topmost upper ones were the tiles' above.
HWY_INLINE void ask_ahead(const std::uint8_t* base, std::ptrdiff_t row_bytes, const std::int32_t* offsets) {
    constexpr int ahead = 128;  // two lines of the cache
    for (int row = 1; row < tile_height; row += 2)
        hwy::Prefetch(base + row_bytes + offsets[(row + 1) * tile_width - 1] + ahead);
}

/// 8 bytes from each of the offsets, one behind the other.
template <typename Tag>
HWY_INLINE hn::Vec<Tag> load_eights(Tag tag, const std::uint8_t* base, const std::int32_t* offsets) {
    constexpr std::size_t groups = hn::MaxLanes(Tag()) / 8;
    if constexpr (groups == 1) {
        return hn::LoadU(tag, base + offsets[0]);
    } else {
        const hn::Half<Tag> half;
        return hn::Combine(tag, load_eights(half, base, offsets + groups / 2), load_eights(half, base, offsets));
    }
}

/// w0 p0 + w1 p1 of neighbouring bytes, weights from 0 to 128 and samples from -128 to 127.
template <typename Tag>
HWY_INLINE hn::Vec<hn::RepartitionToWide<hn::RebindToSigned<Tag>>> weighted_pairs(Tag, hn::Vec<Tag> weights,
                                                                                  hn::Vec<Tag> samples) {
#if HWY_TARGET == HWY_AVX3
    return hwy::HWY_NAMESPACE::Vec512<std::int16_t>{_mm512_maddubs_epi16(weights.raw, samples.raw)};
#elif HWY_TARGET == HWY_AVX2
    return hwy::HWY_NAMESPACE::Vec256<std::int16_t>{_mm256_maddubs_epi16(weights.raw, samples.raw)};
#elif HWY_TARGET == HWY_SSE4 || HWY_TARGET == HWY_SSSE3
    return hwy::HWY_NAMESPACE::Vec128<std::int16_t>{_mm_maddubs_epi16(weights.raw, samples.raw)};
#else
    const hn::RepartitionToWide<hn::RebindToSigned<Tag>> wide;
    const hn::RebindToUnsigned<decltype(wide)> unsigned_wide;
    const auto s = hn::BitCast(wide, samples);
    const auto even = hn::And(hn::BitCast(wide, weights), hn::Set(wide, 0xff));
    const auto odd = hn::BitCast(wide, hn::ShiftRight<8>(hn::BitCast(unsigned_wide, weights)));
    return even * hn::ShiftRight<8>(hn::ShiftLeft<8>(s)) + odd * hn::ShiftRight<8>(s);
#endif
}

}  // namespace equistream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
