#include "noise.h"

#include <cmath>

namespace equistream::generate {
namespace {

std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

std::uint32_t wrapped(int i, int period) {
    const int r = i % period;
    return static_cast<std::uint32_t>(r < 0 ? r + period : r);
}

/// Bijective mixing of 32 bits (Wellons, "lowbias32").
std::uint32_t mix32(std::uint32_t x) {
    x = (x ^ (x >> 16)) * 0x7feb352du;
    x = (x ^ (x >> 15)) * 0x846ca68bu;
    return x ^ (x >> 16);
}

/// Dot product with the lattice point's gradient, one of eight directions.
float along_gradient(std::uint32_t x, std::uint32_t row_key, float dx, float dy) {
    constexpr float h = 0.70710678f;
    constexpr float gradients[8][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {h, h}, {-h, h}, {h, -h}, {-h, -h}};
    const auto& g = gradients[mix32(x ^ row_key) >> 29];
    return g[0] * dx + g[1] * dy;
}

float quintic(float t) {
    return t * t * t * (t * (t * 6 - 15) + 10);
}

}  // namespace

std::uint64_t Random::bits() {
    state_ += 0x9e3779b97f4a7c15u;
    return mix(state_);
}

float noise(glm::vec2 p, Period period, std::uint32_t seed) {
    const glm::vec2 cell = glm::floor(p);
    const glm::vec2 f = p - cell;
    const int column = static_cast<int>(cell.x), row = static_cast<int>(cell.y);
    const std::uint32_t x0 = wrapped(column, period.x), x1 = wrapped(column + 1, period.x);
    const std::uint32_t key0 = mix32(seed + 0x9e3779b9u * wrapped(row, period.y));
    const std::uint32_t key1 = mix32(seed + 0x9e3779b9u * wrapped(row + 1, period.y));
    const float a = along_gradient(x0, key0, f.x, f.y);
    const float b = along_gradient(x1, key0, f.x - 1, f.y);
    const float c = along_gradient(x0, key1, f.x, f.y - 1);
    const float d = along_gradient(x1, key1, f.x - 1, f.y - 1);
    const float u = quintic(f.x), v = quintic(f.y);
    return 1.4f * glm::mix(glm::mix(a, b, u), glm::mix(c, d, u), v);
}

float turbulence(glm::vec2 p, Period period, int octaves, std::uint32_t seed) {
    float sum = 0, amplitude = 1, total = 0;
    for (int octave = 0; octave < octaves; ++octave) {
        sum += amplitude * noise(p, period, seed + static_cast<std::uint32_t>(octave));
        total += amplitude;
        amplitude *= 0.5f;
        p *= 2.0f;
        period = {2 * period.x, 2 * period.y};
    }
    return 1.5f * sum / total;
}

}  // namespace equistream::generate
