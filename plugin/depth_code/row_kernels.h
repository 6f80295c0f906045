#pragma once
/// The codes' arithmetic, a row at a time: by SIMD chosen at run time, and plainly. Both give the same bits.
#include <equistream/depth_code_info.h>

#include <cstdint>
#include <span>

namespace equistream::depth_rows {

/// A DepthRange as rows need it, for samples from 0 to `full`.
struct Scale {
    float box_radius_m = 0;
    float near_m = 0;
    float span_m = 0;    ///< near - B
    float top = 0;       ///< the sample of near_m
    float full = 0;      ///< the sample of no surface, where there is one
    float unpack_m = 0;  ///< span x top: r = B + unpack_m / sample
    float last = 0;      ///< samples above it are no surface
    bool has_empty = false;

    Scale(const DepthRange& range, int full_sample);
};

/// Two rows of depth and where their samples go in 4:2:0: luma of each, and both waves at half the width.
struct PecePair {
    std::span<const float> upper_m, lower_m;  ///< of the same even length
    std::uint8_t* luma[2];
    std::uint8_t* waves[2];
};

/// Packing functions return how many pixels were nearer than near_m. Rows of samples have depth's size.
struct Rows {
    std::int64_t (*pack_w8)(std::span<const float> depth_m, const Scale& scale, std::uint8_t* samples);
    std::int64_t (*pack_w16)(std::span<const float> depth_m, const Scale& scale, std::uint16_t* samples);
    void (*unpack_w8)(const std::uint8_t* samples, const Scale& scale, std::span<float> depth_m);
    void (*unpack_w16)(const std::uint16_t* samples, const Scale& scale, std::span<float> depth_m);

    std::int64_t (*pack_pece)(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]);
    void (*unpack_pece)(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m);

    std::int64_t (*pack_pece420)(const PecePair& pair, const Scale& scale);
    /// The first wave is never read (plain_pixels.h).
    void (*unpack_pece420)(const std::uint8_t* luma, const std::uint8_t* half_wave, const Scale& scale,
                           std::span<float> depth_m);

    std::int64_t (*pack_hue)(std::span<const float> depth_m, const Scale& scale, std::uint8_t* const planes[3]);
    void (*unpack_hue)(const std::uint8_t* const planes[3], const Scale& scale, std::span<float> depth_m);

    void (*pack_bits)(std::span<const float> depth_m, std::uint16_t* const planes[3]);
    void (*unpack_bits)(const std::uint16_t* const planes[3], std::span<float> depth_m);
};

/// The fastest that this processor has.
Rows simd_rows();
/// One pixel after the other: what SIMD rows end with, and are tested against.
Rows plain_rows();

/// Steps of luma in which Pece's code counts: x = 1 stays half a step of 8-bit luma below the top.
inline constexpr int pece_full = 65536 - 129;
inline constexpr int hue_full = 1529;

}  // namespace equistream::depth_rows
