#include "row_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "plugin/depth_code/row_kernels.cpp"
#include <hwy/foreach_target.h>

#include <hwy/highway.h>

#if HWY_TARGET != HWY_SCALAR
#include "pece_rows-inl.h"
#endif

HWY_BEFORE_NAMESPACE();
namespace equistream::depth_rows::HWY_NAMESPACE {

#if HWY_TARGET == HWY_SCALAR

// One lane has no bytes to narrow to.
Rows rows() {
    return plain_rows();
}

#else

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
    return static_cast<std::int64_t>(pack.too_near) +
           plain_rows().pack_hue(depth_m.subspan(x), scale, from_column(planes, x).data());
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
    plain_rows().unpack_hue(from_column(planes, x).data(), scale, depth_m.subspan(x));
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
    plain_rows().pack_bits(depth_m.subspan(x), from_column(planes, x).data());
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
    plain_rows().unpack_bits(from_column(planes, x).data(), depth_m.subspan(x));
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
