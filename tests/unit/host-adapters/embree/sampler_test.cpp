#include <host-adapters/embree/sampler.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace equistream::embree_host {
namespace {

/// Sobol's second dimension by its direction numbers.
std::uint32_t sobol_second(std::uint32_t index) {
    std::uint32_t result = 0;
    for (std::uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
        if (index & 1)
            result ^= v;
    return result;
}

TEST(Sampler, SecondDimensionIsSobols) {
    for (std::uint32_t index : {0u, 1u, 2u, 3u, 77u, 4096u, 123456789u, 0xffffffffu})
        EXPECT_EQ(reverse_bits(sobol_second_reversed(index)), sobol_second(index)) << index;
}

TEST(Sampler, FirstSamplesFillEveryElementaryCellOnce) {
    for (const std::uint64_t seed : {1ull, 99ull, 0xdeadbeefull})
        for (int columns = 1; columns <= 64; columns *= 2) {
            const int rows = 64 / columns;
            std::set<int> cells;
            for (std::uint32_t i = 0; i < 64; ++i) {
                const glm::vec2 u = Sampler(seed, i).pair(1, Sampler::Use::sun);
                cells.insert(static_cast<int>(u.x * static_cast<float>(columns)) * rows +
                             static_cast<int>(u.y * static_cast<float>(rows)));
            }
            EXPECT_EQ(cells.size(), 64u) << columns << " columns, seed " << seed;
        }
}

TEST(Sampler, PixelsUsesAndVerticesAreIndependent) {
    constexpr int pixels = 20000;
    double by_use = 0, by_pixel = 0, by_vertex = 0;
    for (std::uint64_t p = 0; p < pixels; ++p) {
        Sampler a(p * 2654435761u, 0), b((p + 1) * 2654435761u, 0);
        const float x = a.pair(0, Sampler::Use::scattering).x - 0.5f;
        by_use += x * (a.pair(0, Sampler::Use::sun).x - 0.5f);
        by_pixel += x * (b.pair(0, Sampler::Use::scattering).x - 0.5f);
        by_vertex += x * (a.pair(1, Sampler::Use::scattering).x - 0.5f);
    }
    const double sigma = std::sqrt(pixels) / 12;  // of a sum of products of independent uniforms
    EXPECT_LT(std::abs(by_use), 4 * sigma);
    EXPECT_LT(std::abs(by_pixel), 4 * sigma);
    EXPECT_LT(std::abs(by_vertex), 4 * sigma);
}

TEST(Sampler, HashedNumbersAreUniform) {
    std::vector<int> bins(64, 0);
    for (std::uint64_t p = 0; p < 1000; ++p) {
        Sampler sampler(p, 3);
        for (int i = 0; i < 64; ++i)
            ++bins[static_cast<std::size_t>(sampler.next_hashed() * 64)];
    }
    double chi2 = 0;
    for (const int n : bins)
        chi2 += (n - 1000.0) * (n - 1000.0) / 1000.0;
    EXPECT_LT(chi2, 63 + 5 * std::sqrt(2 * 63.0));
}

}  // namespace
}  // namespace equistream::embree_host
