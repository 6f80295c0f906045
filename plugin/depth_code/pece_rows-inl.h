// Rows of Pece et al.'s packing, 4:4:4 and 4:2:0. Included once for each instruction set.
#if defined(EQUISTREAM_PECE_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef EQUISTREAM_PECE_ROWS_INL_H
#undef EQUISTREAM_PECE_ROWS_INL_H
#else
#define EQUISTREAM_PECE_ROWS_INL_H
#endif

#include "packing-inl.h"

#include <algorithm>
#include <span>

HWY_BEFORE_NAMESPACE();
namespace equistream::depth_rows::HWY_NAMESPACE {

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
    return static_cast<std::int64_t>(pack.too_near) +
           plain_rows().pack_pece(depth_m.subspan(x), scale, from_column(planes, x).data());
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
    plain_rows().unpack_pece(from_column(planes, x).data(), scale, depth_m.subspan(x));
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
    plain_rows().unpack_pece420(luma + x, half_wave + x / 2, scale, depth_m.subspan(x));
}

}  // namespace equistream::depth_rows::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
