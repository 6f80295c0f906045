// Vectors of depth as samples and back, which the rows of every depth code are made of. Included once for each
// instruction set.
#if defined(EQUISTREAM_DEPTH_PACKING_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_DEPTH_PACKING_INL_H
#undef EQUISTREAM_DEPTH_PACKING_INL_H
#else
#define EQUISTREAM_DEPTH_PACKING_INL_H
#endif

#include "plain_pixels.h"
#include "row_kernels.h"

#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <limits>

HWY_BEFORE_NAMESPACE();
namespace equistream::depth_rows::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::Rebind<std::int32_t, Floats>;
template <typename T>
using Narrow = hn::Rebind<T, Floats>;
using Float = hn::Vec<Floats>;

/// Adding it to 0 .. 2^22 leaves the nearest whole number in the low bits.
inline constexpr float rounding = 3 << 22;

/// Samples of a vector of depths; counts those that are too near.
struct Packer {
    explicit Packer(const Scale& scale)
        : box(hn::Set(f, scale.box_radius_m)), near(hn::Set(f, scale.near_m)), span(hn::Set(f, scale.span_m)),
          top(hn::Set(f, scale.top)), empty(hn::Set(f, scale.has_empty ? scale.full : 0)) {}

    HWY_INLINE Float operator()(Float depth_m) {
        too_near += hn::CountTrue(f, hn::Lt(depth_m, near));
        const Float inverse = hn::Div(span, hn::Sub(depth_m, box));
        const Float x = hn::IfThenElse(hn::Gt(depth_m, near), inverse, hn::Set(f, 1));
        return hn::IfThenElse(hn::Eq(depth_m, depth_m), hn::Mul(x, top), empty);
    }

    static constexpr Floats f{};
    Float box, near, span, top, empty;
    std::size_t too_near = 0;
};

struct Unpacker {
    explicit Unpacker(const Scale& scale)
        : box(hn::Set(f, scale.box_radius_m)), near(hn::Set(f, scale.near_m)), unpack(hn::Set(f, scale.unpack_m)),
          last(hn::Set(f, scale.last)) {}

    Float operator()(Float sample) const {
        const Float none = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
        const Float depth = hn::Add(hn::Div(unpack, hn::Max(sample, hn::Zero(f))), box);
        return hn::IfThenElse(hn::Gt(sample, last), none, hn::Max(depth, near));
    }

    static constexpr Floats f{};
    Float box, near, unpack, last;
};

/// Three rows from column x on.
template <typename T>
std::array<T*, 3> from_column(T* const planes[3], std::size_t x) {
    return {planes[0] + x, planes[1] + x, planes[2] + x};
}

std::size_t lanes() {
    return hn::Lanes(Floats{});
}

/// Packing goes by two vectors of floats at once, so that their samples fill one of words.
using Words = hn::Repartition<std::uint16_t, Floats>;
using Word = hn::Vec<Words>;

std::size_t at_once() {
    return 2 * lanes();
}

/// Two vectors of values as whole numbers of 16 bits.
HWY_INLINE Word whole_words(Float low, Float high) {
    const Floats f;
    const Float add = hn::Set(f, rounding);
    return hn::ConcatEven(Words(), hn::BitCast(Words(), hn::Add(high, add)), hn::BitCast(Words(), hn::Add(low, add)));
}

HWY_INLINE void store_bytes(Word samples, std::uint8_t* to) {
    const hn::Rebind<std::uint8_t, Words> bytes;
    hn::StoreU(hn::TruncateTo(bytes, samples), bytes, to);
}

/// By how many floats depth is asked for before it is packed. What the processor fetches ahead by itself ends with a
/// page of 4 KiB.
inline constexpr std::size_t ahead = 2048;

HWY_INLINE void ask_for(const float* depth_m) {
    constexpr std::size_t floats_per_line = 16;
    for (std::size_t i = 0; i < at_once(); i += floats_per_line)
        hwy::Prefetch(depth_m + i);
}

/// What packing makes of two vectors of depth.
struct TwoSamples {
    Float low, high;

    HWY_INLINE TwoSamples(Packer& pack, const float* depth_m)
        : low(pack(hn::LoadU(Floats(), depth_m))), high(pack(hn::LoadU(Floats(), depth_m + lanes()))) {}
    HWY_INLINE Word whole() const { return whole_words(low, high); }
};

}  // namespace equistream::depth_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
