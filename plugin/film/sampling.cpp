#include "sampling.h"

#include <algorithm>
#include <cmath>

namespace equistream {
namespace {

/// Owen scrambling of a number whose bits are reversed: each bit is flipped by a hash of the bits below it. Adding
/// and multiplying by even numbers carry upwards only, which is just what that needs.
constexpr std::uint32_t scrambled_reversed(std::uint32_t bits, std::uint32_t seed) {
    bits += seed;
    bits ^= bits * 0x6c50b47cu;
    bits ^= bits * 0xb82f1e52u;
    bits ^= bits * 0xc7afe638u;
    bits ^= bits * 0x8d22f6e6u;
    return bits;
}

/// Second Sobol' dimension, most significant bit first.
constexpr std::uint32_t sobol_second(std::uint32_t index) {
    std::uint32_t result = 0;
    for (std::uint32_t direction = 0x80000000u; index != 0; index >>= 1, direction ^= direction >> 1)
        if (index & 1)
            result ^= direction;
    return result;
}

}  // namespace

SubpixelOffset subpixel_offset(std::uint64_t key, std::uint32_t pixel, std::uint32_t sample) {
    const std::uint64_t seed = mixed(key + std::uint64_t{pixel} * 0x9e3779b97f4a7c15ull);
    // The first dimension is the reversed index, so its reversed bits are the index itself.
    const std::uint32_t first = scrambled_reversed(sample, static_cast<std::uint32_t>(seed));
    const std::uint32_t second =
        scrambled_reversed(reverse_bits(sobol_second(sample)), static_cast<std::uint32_t>(seed >> 32));
    return {unit_float(reverse_bits(first)), unit_float(reverse_bits(second))};
}

std::vector<std::uint32_t> samples_by_angle(const EquirectCamera& camera, int tile_side, std::uint32_t spp) {
    const auto& range = camera.range;
    const double row_rad = range.latitude_span() / camera.height;
    std::vector<std::uint32_t> samples;
    for (int y = 0; y < camera.height; y += tile_side) {
        const double top = range.latitude_max - y * row_rad;
        const double bottom = range.latitude_max - std::min(y + tile_side, camera.height) * row_rad;
        const double mean = std::max(1.0, spp * (std::sin(top) - std::sin(bottom)) / (top - bottom));
        for (int x = 0, tile = 0; x < camera.width; x += tile_side, ++tile)
            samples.push_back(static_cast<std::uint32_t>(std::floor((tile + 1) * mean) - std::floor(tile * mean)));
    }
    return samples;
}

}  // namespace equistream
