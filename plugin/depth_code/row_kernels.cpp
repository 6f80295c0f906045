#include "row_kernels.h"

#include "plain_pixels.h"

#include <hwy/cache_control.h>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "row_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace equistream::depth_rows::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// One lane has no bytes to narrow to.
Rows rows() {
    return plain_rows();
}

#else

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

template <typename T>
std::int64_t pack_w(std::span<const float> depth_m, const Scale& scale, T* samples) {
    Packer pack(scale);
    std::size_t x = 0;
    for (; x + at_once() <= depth_m.size(); x += at_once()) {
        ask_for(&depth_m[x] + ahead);
        const Word whole = TwoSamples(pack, &depth_m[x]).whole();
        if constexpr (sizeof(T) == 1)
            store_bytes(whole, samples + x);
        else
            hn::StoreU(whole, Words(), samples + x);
    }
    auto too_near = static_cast<std::int64_t>(pack.too_near);
    for (; x < depth_m.size(); ++x) {
        samples[x] = static_cast<T>(whole_sample(depth_m[x], scale));
        too_near += depth_m[x] < scale.near_m;
    }
    return too_near;
}

std::int64_t pack_w8(std::span<const float> depth_m, const Scale& scale, std::uint8_t* samples) {
    return pack_w(depth_m, scale, samples);
}
std::int64_t pack_w16(std::span<const float> depth_m, const Scale& scale, std::uint16_t* samples) {
    return pack_w(depth_m, scale, samples);
}

template <typename T>
void unpack_w(const T* samples, const Scale& scale, std::span<float> depth_m) {
    const Floats f;
    const Ints i;
    const Narrow<T> narrow;
    const Unpacker unpack(scale);
    std::size_t x = 0;
    for (; x + lanes() <= depth_m.size(); x += lanes())
        hn::StoreU(unpack(hn::ConvertTo(f, hn::PromoteTo(i, hn::LoadU(narrow, samples + x)))), f, &depth_m[x]);
    for (; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(static_cast<float>(samples[x]), scale);
}

void unpack_w8(const std::uint8_t* samples, const Scale& scale, std::span<float> depth_m) {
    unpack_w(samples, scale, depth_m);
}
void unpack_w16(const std::uint16_t* samples, const Scale& scale, std::span<float> depth_m) {
    unpack_w(samples, scale, depth_m);
}

/// The samples of pece_of, of two vectors. A period is made as long as 16 bits, so that going round is for free and the
/// distance from an even multiple of half a period is an absolute value.
struct PeceSamples {
    Word luma, first, second;

    HWY_INLINE explicit PeceSamples(Word d) {
        constexpr Words words;
        luma = hn::ShiftRight<8>(hn::Add(d, hn::Set(words, pece_half_period / 2)));
        const auto phase = hn::BitCast(signed_words, hn::ShiftLeft<7>(d));
        first = wave(phase);
        second = wave(hn::Sub(phase, hn::Set(signed_words, 1 << 14)));
    }

private:
    static constexpr hn::RebindToSigned<Words> signed_words{};

    /// By numbers below zero, of which there is one more: 2^15 times 255 / 2^15.
    static HWY_INLINE Word wave(hn::Vec<hn::RebindToSigned<Words>> phase) {
        const auto away = hn::Min(phase, hn::Neg(phase));
        return hn::BitCast(Words(), hn::MulFixedPoint15(away, hn::Set(signed_words, -255)));
    }
};

std::int64_t pack_pece(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]) {
    Packer pack(scale);
    std::size_t x = 0;
    for (; x + at_once() <= depth_m.size(); x += at_once()) {
        ask_for(&depth_m[x] + ahead);
        const PeceSamples of(TwoSamples(pack, &depth_m[x]).whole());
        store_bytes(of.luma, planes[0] + x);
        store_bytes(of.first, planes[1] + x);
        store_bytes(of.second, planes[2] + x);
    }
    auto too_near = static_cast<std::int64_t>(pack.too_near);
    for (; x < depth_m.size(); ++x) {
        const auto samples = pece_of(depth_m[x], scale);
        for (int i = 0; i < 3; ++i)
            planes[i][x] = samples[i];
        too_near += depth_m[x] < scale.near_m;
    }
    return too_near;
}

/// Of the sums of two rows' samples, in pairs: the mean of four.
HWY_INLINE void store_means(Word sums, std::uint8_t* to) {
    const hn::RepartitionToWide<Words> pairs;
    const auto pair = hn::BitCast(pairs, sums);
    const auto four = hn::Add(hn::And(pair, hn::Set(pairs, 0xffff)), hn::ShiftRight<16>(pair));
    const hn::Rebind<std::uint8_t, decltype(pairs)> bytes;
    hn::StoreU(hn::TruncateTo(bytes, hn::ShiftRight<2>(hn::Add(four, hn::Set(pairs, 2)))), bytes, to);
}

/// Columns of a pair of rows whose waves are kept until the lower row is there: one row at a time is read, as what the
/// processor fetches ahead by itself follows one, and what is kept stays in a core's first cache.
inline constexpr std::size_t kept_columns = 2048;

struct KeptWaves {
    alignas(64) std::uint16_t first[kept_columns], second[kept_columns];
};

// Both make a packer of their own: bytes that are stored could be one that lives elsewhere.
std::size_t pack_upper(const Scale& scale, std::span<const float> depth_m, std::uint8_t* luma, KeptWaves& waves) {
    Packer pack(scale);
    for (std::size_t x = 0; x < depth_m.size(); x += at_once()) {
        ask_for(&depth_m[x] + ahead);
        const PeceSamples of(TwoSamples(pack, &depth_m[x]).whole());
        store_bytes(of.luma, luma + x);
        hn::Store(of.first, Words(), waves.first + x);
        hn::Store(of.second, Words(), waves.second + x);
    }
    return pack.too_near;
}

std::size_t pack_lower(const Scale& scale, std::span<const float> depth_m, std::uint8_t* luma, const KeptWaves& waves,
                       std::uint8_t* first, std::uint8_t* second) {
    Packer pack(scale);
    for (std::size_t x = 0; x < depth_m.size(); x += at_once()) {
        ask_for(&depth_m[x] + ahead);
        const PeceSamples of(TwoSamples(pack, &depth_m[x]).whole());
        store_bytes(of.luma, luma + x);
        store_means(hn::Add(of.first, hn::Load(Words(), waves.first + x)), first + x / 2);
        store_means(hn::Add(of.second, hn::Load(Words(), waves.second + x)), second + x / 2);
    }
    return pack.too_near;
}

std::int64_t pack_pece420(const PecePair& pair, const Scale& scale) {
    const std::size_t whole = pair.upper_m.size() / at_once() * at_once();
    std::size_t too_near = 0;
    KeptWaves waves;
    for (std::size_t x = 0; x < whole; x += kept_columns) {
        const std::size_t columns = std::min(kept_columns, whole - x);
        too_near += pack_upper(scale, pair.upper_m.subspan(x, columns), pair.luma[0] + x, waves);
        too_near += pack_lower(scale, pair.lower_m.subspan(x, columns), pair.luma[1] + x, waves, pair.waves[0] + x / 2,
                               pair.waves[1] + x / 2);
    }
    return static_cast<std::int64_t>(too_near) + pece420_from(pair, scale, whole);
}

struct PeceSteps {
    Float half, quarter, from_byte;
};

/// pece_sample of a register.
Float pece_samples(hn::Vec<Ints> luma, hn::Vec<Ints> wave, const PeceSteps& steps) {
    const Floats f;
    const Ints i;
    const auto rising = hn::Ne(hn::And(luma, hn::Set(i, 1)), hn::Zero(i));
    const auto along = hn::IfThenElse(rising, wave, hn::Sub(hn::Set(i, 255), wave));
    const Float start = hn::Sub(hn::Mul(hn::ConvertTo(f, luma), steps.half), steps.quarter);
    return hn::Add(start, hn::Mul(hn::ConvertTo(f, along), steps.from_byte));
}

void unpack_pece(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m) {
    const Floats f;
    const Ints i;
    const Narrow<std::uint8_t> narrow;
    const Float half = hn::Set(f, pece_half_period), quarter = hn::Set(f, pece_half_period / 2);
    const Float from_byte = hn::Set(f, pece_half_period / 255.0f);
    const Unpacker unpack(scale);
    const auto load = [&](const std::uint8_t* at) { return hn::PromoteTo(i, hn::LoadU(narrow, at)); };
    std::size_t x = 0;
    for (; x + lanes() <= depth_m.size(); x += lanes()) {
        const auto luma = load(planes[0] + x), wave = load(planes[2] + x);
        hn::StoreU(unpack(pece_samples(luma, wave, {half, quarter, from_byte})), f, &depth_m[x]);
    }
    for (; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(pece_sample({planes[0][x], planes[1][x], planes[2][x]}), scale);
}

void unpack_pece420(const std::uint8_t* luma, const std::uint8_t* half_wave, const Scale& scale,
                    std::span<float> depth_m) {
    const Floats f;
    const Ints i;
    const hn::Rebind<std::uint8_t, Words> bytes;
    const Narrow<std::uint8_t> narrow;
    const hn::Half<Words> pairs;
    const hn::Rebind<std::uint8_t, hn::Half<Words>> half;
    const Float half_period = hn::Set(f, pece_half_period), quarter = hn::Set(f, pece_half_period / 2);
    const Float from_byte = hn::Set(f, pece_half_period / 255.0f);
    const Unpacker unpack(scale);
    std::size_t x = 0;
    for (; x + at_once() <= depth_m.size(); x += at_once()) {
        // Every wave twice, for two vectors of pixels.
        const auto once = hn::PromoteTo(pairs, hn::LoadU(half, half_wave + x / 2));
        const auto twice = hn::BitCast(bytes, hn::Or(once, hn::ShiftLeft<8>(once)));
        const auto top = hn::LoadU(bytes, luma + x);
        const auto store = [&](auto luma_bytes, auto wave_bytes, float* to) HWY_ATTR {
            const auto samples = pece_samples(hn::PromoteTo(i, luma_bytes), hn::PromoteTo(i, wave_bytes),
                                              {half_period, quarter, from_byte});
            hn::StoreU(unpack(samples), f, to);
        };
        store(hn::LowerHalf(narrow, top), hn::LowerHalf(narrow, twice), &depth_m[x]);
        store(hn::UpperHalf(narrow, top), hn::UpperHalf(narrow, twice), &depth_m[x + lanes()]);
    }
    for (; x < depth_m.size(); ++x)
        depth_m[x] = depth_of(pece_sample({luma[x], 0, half_wave[x / 2]}), scale);
}

std::int64_t pack_hue(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]) {
    const Floats f;
    const hn::RebindToSigned<Words> i;
    const hn::Rebind<std::uint8_t, Words> bytes;
    Packer pack(scale);
    std::size_t x = 0;
    for (; x + at_once() <= depth_m.size(); x += at_once()) {
        ask_for(&depth_m[x] + ahead);
        const auto hue = hn::BitCast(i, TwoSamples(pack, &depth_m[x]).whole());
        const Float low = hn::LoadU(f, &depth_m[x]), high = hn::LoadU(f, &depth_m[x] + lanes());
        const auto away_from = [&](std::int16_t middle) HWY_ATTR { return hn::Abs(hn::Sub(hue, hn::Set(i, middle))); };
        auto green = hn::Sub(hn::Set(i, 510), away_from(510)), blue = hn::Sub(hn::Set(i, 510), away_from(1020));
        auto red = hn::Sub(away_from(765), hn::Set(i, 255));
        if (scale.has_empty && !hn::AllTrue(f, hn::And(hn::Eq(low, low), hn::Eq(high, high)))) {
            const auto whole = [&](Float depth)
                                   HWY_ATTR { return hn::BitCast(Words(), hn::VecFromMask(f, hn::Eq(depth, depth))); };
            const auto kept = hn::BitCast(i, hn::ConcatEven(Words(), whole(high), whole(low)));
            green = hn::And(green, kept);
            blue = hn::And(blue, kept);
            red = hn::And(red, kept);
        }
        // What is below 0 or above 255 stops there.
        hn::StoreU(hn::DemoteTo(bytes, green), bytes, planes[0] + x);
        hn::StoreU(hn::DemoteTo(bytes, blue), bytes, planes[1] + x);
        hn::StoreU(hn::DemoteTo(bytes, red), bytes, planes[2] + x);
    }
    auto too_near = static_cast<std::int64_t>(pack.too_near);
    for (; x < depth_m.size(); ++x) {
        const auto gbr = hue_of(depth_m[x], scale);
        for (int plane = 0; plane < 3; ++plane)
            planes[plane][x] = gbr[plane];
        too_near += depth_m[x] < scale.near_m;
    }
    return too_near;
}

void unpack_hue(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m) {
    const Floats f;
    const Ints i;
    const Narrow<std::uint8_t> narrow;
    const Unpacker unpack(scale);
    const Float none = hn::Set(f, std::numeric_limits<float>::quiet_NaN());
    std::size_t x = 0;
    for (; x + lanes() <= depth_m.size(); x += lanes()) {
        const auto load = [&](int plane) { return hn::PromoteTo(i, hn::LoadU(narrow, planes[plane] + x)); };
        const auto g = load(0), b = load(1), r = load(2);
        const auto no_less = [](auto one, auto other) { return hn::Not(hn::Lt(one, other)); };
        const auto from_red = hn::Sub(g, b);
        const auto below_red = hn::Min(hn::Add(from_red, hn::Set(i, 1530)), hn::Set(i, hue_full));
        const auto red = hn::IfThenElse(no_less(g, b), from_red, below_red);
        const auto green = hn::Add(hn::Sub(b, r), hn::Set(i, 510));
        const auto blue = hn::Add(hn::Sub(r, g), hn::Set(i, 1020));
        const auto hue =
            hn::IfThenElse(hn::And(no_less(r, g), no_less(r, b)), red, hn::IfThenElse(no_less(g, b), green, blue));
        const auto black = hn::RebindMask(f, hn::Lt(hn::Add(hn::Add(r, g), b), hn::Set(i, hue_darkest)));
        hn::StoreU(hn::IfThenElse(black, none, unpack(hn::ConvertTo(f, hue))), f, &depth_m[x]);
    }
    for (; x < depth_m.size(); ++x)
        depth_m[x] = depth_of_hue({planes[0][x], planes[1][x], planes[2][x]}, scale);
}

void pack_bits(std::span<const float> depth_m, std::uint16_t* const planes[3]) {
    const Floats f;
    const Ints i;
    const Narrow<std::uint16_t> narrow;
    std::size_t x = 0;
    for (; x + lanes() <= depth_m.size(); x += lanes()) {
        const auto bits = hn::And(hn::BitCast(i, hn::LoadU(f, &depth_m[x])), hn::Set(i, 0x7fffffff));
        hn::StoreU(hn::DemoteTo(narrow, hn::ShiftRight<19>(bits)), narrow, planes[0] + x);
        hn::StoreU(hn::DemoteTo(narrow, hn::And(hn::ShiftRight<7>(bits), hn::Set(i, 0xfff))), narrow, planes[1] + x);
        hn::StoreU(hn::DemoteTo(narrow, hn::And(bits, hn::Set(i, 0x7f))), narrow, planes[2] + x);
    }
    for (; x < depth_m.size(); ++x) {
        const auto words = bits_of(depth_m[x]);
        for (int plane = 0; plane < 3; ++plane)
            planes[plane][x] = words[plane];
    }
}

void unpack_bits(const std::uint16_t* const planes[3], std::span<float> depth_m) {
    const Floats f;
    const Ints i;
    const Narrow<std::uint16_t> narrow;
    std::size_t x = 0;
    for (; x + lanes() <= depth_m.size(); x += lanes()) {
        const auto load = [&](int plane, int mask) {
            return hn::And(hn::PromoteTo(i, hn::LoadU(narrow, planes[plane] + x)), hn::Set(i, mask));
        };
        const auto bits =
            hn::Or(hn::Or(hn::ShiftLeft<19>(load(0, 0xfff)), hn::ShiftLeft<7>(load(1, 0xfff))), load(2, 0x7f));
        hn::StoreU(hn::BitCast(f, bits), f, &depth_m[x]);
    }
    for (; x < depth_m.size(); ++x)
        depth_m[x] = depth_of_bits({planes[0][x], planes[1][x], planes[2][x]});
}

Rows rows() {
    return {pack_w8,      pack_w16,       unpack_w8, unpack_w16, pack_pece, unpack_pece,
            pack_pece420, unpack_pece420, pack_hue,  unpack_hue, pack_bits, unpack_bits};
}

#endif

}  // namespace equistream::depth_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace equistream::depth_rows {

HWY_EXPORT(rows);

Rows simd_rows() {
    return HWY_DYNAMIC_DISPATCH(rows)();
}

}  // namespace equistream::depth_rows
#endif
