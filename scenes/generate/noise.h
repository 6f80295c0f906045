#pragma once
/// Reproducible randomness: the same numbers on every machine, unlike the distributions of <random>.
#include <glm/glm.hpp>

#include <cstdint>

namespace equistream::generate {

/// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    std::uint64_t bits();
    float uniform() { return static_cast<float>(bits() >> 40) * 0x1p-24f; }  ///< [0, 1)
    float between(float low, float high) { return low + (high - low) * uniform(); }

private:
    std::uint64_t state_;
};

/// Cells after which noise repeats, along x and y.
struct Period {
    Period(int both) : x(both), y(both) {}
    Period(int along_x, int along_y) : x(along_x), y(along_y) {}
    int x, y;
};

/// Gradient noise in about [-1, 1] that repeats with `period`.
float noise(glm::vec2 p, Period period, std::uint32_t seed);

/// Sum of `octaves` of noise, halving the amplitude and doubling the frequency; about [-1, 1]. Repeats with `period`.
float turbulence(glm::vec2 p, Period period, int octaves, std::uint32_t seed);

}  // namespace equistream::generate
