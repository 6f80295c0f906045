#pragma once
/// Random numbers of one path: Owen-scrambled Sobol points for the first vertices, hashed numbers after them.
/// Each pair of dimensions is the (0,2)-sequence of Sobol's first two dimensions, shuffled and scrambled by hashes
/// (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020). Points with different seeds are independent.
#include <plugin/film/sampling.h>

#include <glm/glm.hpp>

#include <cstdint>

namespace equistream::embree_host {

/// A 32-bit finaliser (full avalanche) of 64 bits.
inline std::uint32_t hash_bits(std::uint64_t x) {
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ull;
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ull;
    return static_cast<std::uint32_t>(x >> 32);
}

/// Owen scrambling of a value whose bits are reversed: each bit is flipped by a hash of the bits below it.
inline std::uint32_t scramble_reversed(std::uint32_t x, std::uint32_t seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/// Sobol's second dimension of an index, with its bits reversed: Pascal's triangle modulo 2 times the index, which
/// factors into one shift and xor per bit of the bit's number.
inline std::uint32_t sobol_second_reversed(std::uint32_t index) {
    index ^= (index >> 1) & 0x55555555u;
    index ^= (index >> 2) & 0x33333333u;
    index ^= (index >> 4) & 0x0f0f0f0fu;
    index ^= (index >> 8) & 0x00ff00ffu;
    index ^= (index >> 16) & 0x0000ffffu;
    return index;
}

class Sampler {
public:
    /// `sky` comes after the four of both vertices: a new use leaves the numbers of the others as they were.
    enum class Use : std::uint32_t { scattering, choices, sun, emitter, sky = 8 };

    Sampler() = default;
    /// `pixel_seed` is the same for all samples of a pixel and differs between pixels; `sample` counts from 0.
    Sampler(std::uint64_t pixel_seed, std::uint32_t sample)
        : pixel_seed_(hash_bits(pixel_seed)), reversed_sample_(reverse_bits(sample)),
          state_(hash_bits(pixel_seed + 0x9e3779b97f4a7c15ull * (std::uint64_t{sample} + 1))) {}

    /// Numbers for one use at one vertex of the path; stratified over samples at the first vertices.
    glm::vec2 pair(std::uint32_t vertex, Use use) {
        if (vertex >= sobol_vertices)
            return {next_hashed(), next_hashed()};
        const std::uint32_t number = vertex * 4 + static_cast<std::uint32_t>(use) + 1;
        const std::uint64_t stream = (std::uint64_t{pixel_seed_} << 32) | number;
        const std::uint32_t shuffled = reverse_bits(scramble_reversed(reversed_sample_, hash_bits(stream)));
        const std::uint32_t x = scramble_reversed(shuffled, hash_bits(stream ^ 0x5bd1e900u));
        const std::uint32_t y = scramble_reversed(sobol_second_reversed(shuffled), hash_bits(stream ^ 0xa3b19500u));
        return {unit_float(reverse_bits(x)), unit_float(reverse_bits(y))};
    }

    /// An independent number, for decisions that gain nothing from stratification.
    float next_hashed() {
        state_ = state_ * 747796405u + 2891336453u;
        const std::uint32_t word = ((state_ >> ((state_ >> 28) + 4u)) ^ state_) * 277803737u;
        return unit_float((word >> 22) ^ word);
    }

    static constexpr std::uint32_t sobol_vertices = 2;

private:
    std::uint32_t pixel_seed_ = 0;
    std::uint32_t reversed_sample_ = 0;
    std::uint32_t state_ = 0;
};

}  // namespace equistream::embree_host
