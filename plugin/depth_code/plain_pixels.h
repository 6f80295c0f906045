#pragma once
/// One pixel of each code.
#include "row_kernels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

namespace equistream::depth_rows {

/// x times the top sample, not rounded.
inline float sample_of(float depth_m, const Scale& scale) {
    if (std::isnan(depth_m))
        return scale.has_empty ? scale.full : 0;
    const float x = depth_m > scale.near_m ? scale.span_m / (depth_m - scale.box_radius_m) : 1;
    return x * scale.top;
}

/// The nearest; of two that are as near, the even one.
inline int whole(float value) {
    return static_cast<int>(std::nearbyint(value));
}

inline int whole_sample(float depth_m, const Scale& scale) {
    return whole(sample_of(depth_m, scale));
}

inline float depth_of(float sample, const Scale& scale) {
    if (sample > scale.last)
        return std::numeric_limits<float>::quiet_NaN();
    return std::max(scale.unpack_m / std::max(sample, 0.0f) + scale.box_radius_m, scale.near_m);
}

/// Half a period of Pece's waves: n_p = 512 of 65,536.
inline constexpr int pece_half_period = 256;

/// The wave at a whole d, from 0 at even multiples of half a period to 255 at odd ones.
inline std::uint8_t pece_wave(int d) {
    const int phase = d & (2 * pece_half_period - 1);
    const int along = std::min(phase, 2 * pece_half_period - phase);
    return static_cast<std::uint8_t>((along * 255 + pece_half_period / 2) / pece_half_period);
}

/// The paper's depth is of 16 bits, so d is whole before anything is made of it.
inline std::array<std::uint8_t, 3> pece_of(float depth_m, const Scale& scale) {
    const int d = whole_sample(depth_m, scale);
    return {static_cast<std::uint8_t>((d + pece_half_period / 2) / pece_half_period), pece_wave(d),
            pece_wave(d - pece_half_period / 2)};
}

/// From column `first`, which is even, on; how many were too near.
inline std::int64_t pece420_from(const PecePair& pair, const Scale& scale, std::size_t first) {
    std::int64_t too_near = 0;
    for (std::size_t x = first; x < pair.upper_m.size(); x += 2) {
        int sums[2] = {2, 2};
        for (int row = 0; row < 2; ++row)
            for (std::size_t i = x; i < x + 2; ++i) {
                const float depth_m = (row == 0 ? pair.upper_m : pair.lower_m)[i];
                const auto samples = pece_of(depth_m, scale);
                pair.luma[row][i] = samples[0];
                sums[0] += samples[1];
                sums[1] += samples[2];
                too_near += depth_m < scale.near_m;
            }
        for (int wave = 0; wave < 2; ++wave)
            pair.waves[wave][x / 2] = static_cast<std::uint8_t>(sums[wave] / 4);
    }
    return too_near;
}

/// Luma of 8 bits is always at the start or in the middle of a period (a step is half of one), where the paper's m(L)
/// is 3 or 1: its rule never looks at the first wave, and L0 = L - p/4.
inline float pece_sample(const std::array<std::uint8_t, 3>& planes) {
    constexpr float from_byte = pece_half_period / 255.0f;
    const bool rising = planes[0] % 2 != 0;
    const float along = static_cast<float>(rising ? planes[2] : 255 - planes[2]) * from_byte;
    return static_cast<float>(planes[0]) * pece_half_period - pece_half_period / 2 + along;
}

/// G, B, R of a hue from 0 to 1,529, whose full circle is 1,530.
inline std::array<std::uint8_t, 3> hue_of(float depth_m, const Scale& scale) {
    if (std::isnan(depth_m) && scale.has_empty)
        return {0, 0, 0};
    const int hue = whole_sample(depth_m, scale);
    const auto channel = [](int value) { return static_cast<std::uint8_t>(std::clamp(value, 0, 255)); };
    return {channel(510 - std::abs(hue - 510)), channel(510 - std::abs(hue - 1020)),
            channel(std::abs(hue - 765) - 255)};
}

/// Darker than this in all, a pixel is black that a codec has changed.
inline constexpr int hue_darkest = 128;

inline float depth_of_hue(const std::array<std::uint8_t, 3>& gbr, const Scale& scale) {
    const int g = gbr[0], b = gbr[1], r = gbr[2];
    if (r + g + b < hue_darkest)
        return std::numeric_limits<float>::quiet_NaN();
    int hue = r - g + 1020;
    if (r >= g && r >= b)
        hue = g >= b ? g - b : std::min(g - b + 1530, hue_full);
    else if (g >= b)
        hue = b - r + 510;
    return depth_of(static_cast<float>(hue), scale);
}

/// Sign aside, which depth has none of: exponent and first 4 bits, 12 bits, the last 7.
inline std::array<std::uint16_t, 3> bits_of(float depth_m) {
    const auto bits = std::bit_cast<std::uint32_t>(depth_m) & 0x7fffffffu;
    return {static_cast<std::uint16_t>(bits >> 19), static_cast<std::uint16_t>(bits >> 7 & 0xfff),
            static_cast<std::uint16_t>(bits & 0x7f)};
}

inline float depth_of_bits(const std::array<std::uint16_t, 3>& words) {
    return std::bit_cast<float>((words[0] & 0xfffu) << 19 | (words[1] & 0xfffu) << 7 | (words[2] & 0x7fu));
}

}  // namespace equistream::depth_rows
