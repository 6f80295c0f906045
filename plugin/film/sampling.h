#pragma once
/// Where colour samples lie within a pixel, and the seeds of rays. Pure functions of (seed, frame, pixel, sample), so
/// an image does not depend on the number of threads or on the order of tiles.
#include <equistream/camera.h>

#include <cstdint>
#include <vector>

namespace equistream {

/// A bijection of 64-bit words that spreads every input bit over all of them.
constexpr std::uint64_t mixed(std::uint64_t word) {
    word ^= word >> 32;
    word *= 0xd6e8feb86659fd93ull;
    word ^= word >> 32;
    word *= 0xd6e8feb86659fd93ull;
    word ^= word >> 32;
    return word;
}

constexpr std::uint32_t reverse_bits(std::uint32_t x) {
    x = __builtin_bswap32(x);
    x = ((x >> 4) & 0x0f0f0f0fu) | ((x & 0x0f0f0f0fu) << 4);
    x = ((x >> 2) & 0x33333333u) | ((x & 0x33333333u) << 2);
    return ((x >> 1) & 0x55555555u) | ((x & 0x55555555u) << 1);
}

/// [0, 1): never 1, also after rounding to float.
constexpr float unit_float(std::uint32_t bits) {
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

/// What all rays of one frame share.
constexpr std::uint64_t frame_key(std::uint64_t sequence_seed, std::int64_t frame_index) {
    return mixed(mixed(sequence_seed) + static_cast<std::uint64_t>(frame_index) * 0x9e3779b97f4a7c15ull);
}

/// Samples are counted from 0; this one stands for the pixel-centre ray.
inline constexpr std::uint32_t geometry_sample = std::uint32_t{1} << 20;

/// Of those that are in no picture (reference_tiles.h).
inline constexpr std::uint32_t first_reference_sample = geometry_sample + 1;

/// Distinct for distinct (pixel, sample) of one frame: samples take 21 bits, pixels those above.
constexpr std::uint64_t ray_seed(std::uint64_t key, std::uint32_t pixel, std::uint32_t sample) {
    return mixed(key ^ (std::uint64_t{pixel} << 21 | sample));
}

struct SubpixelOffset {
    float u, v;  ///< in [0, 1)
};

/// Sample number `sample` of one pixel: the first two Sobol' dimensions with a random Owen scrambling per pixel (by
/// hashing: Laine and Karras 2011, Burley 2020). Any 2^k first samples fall one into each of the 2^k cells of every
/// elementary partition (4 x 4 as well as 16 x 1); pixels are independent of each other.
SubpixelOffset subpixel_offset(std::uint64_t key, std::uint32_t pixel, std::uint32_t sample);

/// Colour passes by tile in proportion to the solid angle of its pixels: `spp` on the equator, one at least. Tiles of a
/// row differ by one at most, and have the row's mean together.
std::vector<std::uint32_t> samples_by_angle(const EquirectCamera& camera, int tile_side, std::uint32_t spp);

}  // namespace equistream
