#include "noise.h"

#include <array>
#include <cmath>

namespace equistream::generate {
namespace {

std::uint64_t mix(std::uint64_t z) {
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

int wrapped(int i, int period) {
    const int r = i % period;
    return r < 0 ? r + period : r;
}

/// One of eight gradients; two octagon rings would look the same at this amplitude.
float lattice(int x, int y, Period period, std::uint32_t seed, glm::vec2 offset) {
    const auto key =
        (std::uint64_t{seed} << 40) ^ (std::uint64_t(wrapped(x, period.x)) << 20) ^ std::uint64_t(wrapped(y, period.y));
    constexpr float h = 0.70710678f;
    constexpr std::array<std::array<float, 2>, 8> gradients{
        {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {h, h}, {-h, h}, {h, -h}, {-h, -h}}};
    const auto& g = gradients[mix(key + 0x9e3779b97f4a7c15u) >> 61];
    return g[0] * offset.x + g[1] * offset.y;
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
    const int x = static_cast<int>(cell.x), y = static_cast<int>(cell.y);
    const float a = lattice(x, y, period, seed, f);
    const float b = lattice(x + 1, y, period, seed, f - glm::vec2(1, 0));
    const float c = lattice(x, y + 1, period, seed, f - glm::vec2(0, 1));
    const float d = lattice(x + 1, y + 1, period, seed, f - glm::vec2(1, 1));
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
