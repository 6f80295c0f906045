#include <host-adapters/embree/bsdf.h>
#include <host-adapters/embree/directions.h>
#include <host-adapters/embree/sampler.h>

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace equistream::embree_host {
namespace {

glm::vec3 viewer_at(float cosine) {
    return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

/// Density of the reflected direction that sampling visible normals gives.
float ggx_reflection_pdf(const glm::vec3& viewer, const glm::vec3& half, float alpha) {
    return ggx_distribution(half, alpha) / ((1 + ggx_lambda(viewer, alpha)) * 4 * viewer.z);
}

/// A direction of the upper hemisphere by cosine and azimuth in [0, 1)^2; each stands for 2 pi / n.
glm::vec3 hemisphere_cell(const glm::vec2& u) {
    const float z = u.x, r = std::sqrt(1 - z * z), phi = 2 * pi_f * u.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
}

template <typename Function>
double integrate_hemisphere(Function f, int side = 1500) {
    double sum = 0;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
            sum += f(hemisphere_cell({(static_cast<float>(i) + 0.5f) / static_cast<float>(side),
                                      (static_cast<float>(j) + 0.5f) / static_cast<float>(side)}));
    return sum * 2 * pi_f / (static_cast<double>(side) * side);
}

SurfaceParameters metal(float roughness) {
    return {glm::vec3(1), 1, roughness, 0, 0.04f};
}
SurfaceParameters plastic(float roughness, const glm::vec3& colour) {
    return {colour, 0, roughness, 0, 0.04f};
}

/// Mean weight of samples: what the surface reflects and transmits of a uniform surrounding.
glm::dvec3 albedo_by_sampling(const SurfaceParameters& parameters, float cosine, int samples = 1 << 16) {
    const glm::vec3 viewer = viewer_at(cosine);
    const Bsdf bsdf(parameters, cosine);
    glm::dvec3 sum{0};
    for (int i = 0; i < samples; ++i) {
        Sampler sampler(42, static_cast<std::uint32_t>(i));
        const float lobe = sampler.pair(0, Sampler::Use::choices).x;
        const BsdfSample s = bsdf.sample(viewer, lobe, sampler.pair(0, Sampler::Use::scattering));
        if (s.kind != BsdfSample::Kind::none)
            sum += glm::dvec3(s.weight);
    }
    return sum / static_cast<double>(samples);
}

TEST(Ggx, NormalsWeightedByCosineIntegrateToOne) {
    for (const float alpha : {0.1f, 0.3f, 0.7f, 1.0f})
        EXPECT_NEAR(integrate_hemisphere([&](const glm::vec3& h) { return ggx_distribution(h, alpha) * h.z; }), 1, 2e-3)
            << alpha;
}

TEST(Ggx, PdfPlusWhatFallsBelowTheHorizonIsOne) {
    for (const float alpha : {0.15f, 0.5f, 1.0f})
        for (const float cosine : {0.2f, 0.6f, 1.0f}) {
            const glm::vec3 viewer = viewer_at(cosine);
            const double above = integrate_hemisphere([&](const glm::vec3& light) {
                return ggx_reflection_pdf(viewer, glm::normalize(viewer + light), alpha);
            });
            int below = 0;
            constexpr int samples = 100000;
            for (int i = 0; i < samples; ++i) {
                const glm::vec2 u = Sampler(5, static_cast<std::uint32_t>(i)).pair(0, Sampler::Use::scattering);
                const glm::vec3 half = ggx_sample_visible_normal(viewer, alpha, u);
                below += (2 * glm::dot(viewer, half) * half - viewer).z <= 0;
            }
            EXPECT_NEAR(above + static_cast<double>(below) / samples, 1, 4e-3) << alpha << " " << cosine;
        }
}

TEST(Ggx, SamplesFollowThePdf) {
    // Chi-square over cells of equal solid angle; expected counts by integrating the pdf finely within each.
    constexpr int side = 12, fine = 24, samples = 200000;
    for (const float alpha : {0.3f, 0.8f})
        for (const float cosine : {0.35f, 0.9f}) {
            const glm::vec3 viewer = viewer_at(cosine);
            std::vector<double> expected(side * side, 0), counted(side * side, 0);
            for (int i = 0; i < side * fine; ++i)
                for (int j = 0; j < side * fine; ++j) {
                    const glm::vec3 light = hemisphere_cell({(static_cast<float>(i) + 0.5f) / (side * fine),
                                                             (static_cast<float>(j) + 0.5f) / (side * fine)});
                    expected[static_cast<std::size_t>(i / fine * side + j / fine)] +=
                        ggx_reflection_pdf(viewer, glm::normalize(viewer + light), alpha) * 2 * pi_f * samples /
                        (static_cast<double>(side * fine) * side * fine);
                }
            for (int n = 0; n < samples; ++n) {
                Sampler random(static_cast<std::uint64_t>(n) * 77 + 5, 0);
                const glm::vec3 half =
                    ggx_sample_visible_normal(viewer, alpha, {random.next_hashed(), random.next_hashed()});
                const glm::vec3 light = 2 * glm::dot(viewer, half) * half - viewer;
                if (light.z <= 0)
                    continue;
                const float turn = std::atan2(light.y, light.x) / (2 * pi_f);
                const int i = std::min(side - 1, static_cast<int>(light.z * side));
                const int j = std::min(side - 1, static_cast<int>((turn < 0 ? turn + 1 : turn) * side));
                ++counted[static_cast<std::size_t>(i * side + j)];
            }
            double chi2 = 0;
            int cells = 0;
            for (std::size_t c = 0; c < expected.size(); ++c)
                if (expected[c] > 20) {
                    chi2 += (counted[c] - expected[c]) * (counted[c] - expected[c]) / expected[c];
                    ++cells;
                }
            EXPECT_LT(chi2, cells + 5 * std::sqrt(2.0 * cells)) << alpha << " " << cosine << ", " << cells << " cells";
        }
}

TEST(Bsdf, FurnaceIsOneForWhite) {
    for (const float cosine : {0.1f, 0.4f, 1.0f}) {
        for (const float roughness : {0.0f, 0.1f, 0.4f, 0.7f, 1.0f}) {
            EXPECT_NEAR(albedo_by_sampling(metal(roughness), cosine).y, 1, 0.01)
                << "metal " << roughness << " " << cosine;
            EXPECT_NEAR(albedo_by_sampling(plastic(roughness, glm::vec3(1)), cosine).y, 1, 0.01)
                << "plastic " << roughness << " " << cosine;
        }
        SurfaceParameters glass = plastic(0, glm::vec3(1));
        glass.transmission = 1;
        EXPECT_NEAR(albedo_by_sampling(glass, cosine).y, 1, 0.01) << "glass " << cosine;
        glass.transmission = 0.5f;
        EXPECT_NEAR(albedo_by_sampling(glass, cosine).y, 1, 0.01) << "half glass " << cosine;
    }
}

TEST(Bsdf, SamplingAgreesWithIntegratingTheValue) {
    for (const float roughness : {0.3f, 0.6f, 1.0f})
        for (const float cosine : {0.3f, 0.8f}) {
            const SurfaceParameters parameters{{0.8f, 0.4f, 0.2f}, 0.3f, roughness, 0, 0.04f};
            const Bsdf bsdf(parameters, cosine);
            const glm::vec3 viewer = viewer_at(cosine);
            const glm::dvec3 sampled = albedo_by_sampling(parameters, cosine);
            const double red =
                integrate_hemisphere([&](const glm::vec3& l) { return bsdf.evaluate(viewer, l).value.x; });
            const double blue =
                integrate_hemisphere([&](const glm::vec3& l) { return bsdf.evaluate(viewer, l).value.z; });
            EXPECT_NEAR(sampled.x, red, 0.01) << roughness << " " << cosine;
            EXPECT_NEAR(sampled.z, blue, 0.01) << roughness << " " << cosine;
        }
}

TEST(Bsdf, SampleCarriesTheDensityOfEvaluate) {
    const SurfaceParameters parameters{{0.8f, 0.4f, 0.2f}, 0.3f, 0.4f, 0, 0.04f};
    const Bsdf bsdf(parameters, 0.6f);
    const glm::vec3 viewer = viewer_at(0.6f);
    for (std::uint32_t i = 0; i < 100; ++i) {
        Sampler sampler(9, i);
        const BsdfSample s =
            bsdf.sample(viewer, sampler.pair(0, Sampler::Use::choices).x, sampler.pair(0, Sampler::Use::scattering));
        if (s.kind != BsdfSample::Kind::rough)
            continue;
        const BsdfValue value = bsdf.evaluate(viewer, s.direction);
        EXPECT_FLOAT_EQ(s.pdf, value.pdf);
        EXPECT_NEAR(s.weight.x, value.value.x / value.pdf, 1e-4 * s.weight.x);
    }
}

TEST(Bsdf, ThinGlassLetsLightStraightOnTinted) {
    SurfaceParameters glass = plastic(0, {0.5f, 0.25f, 1});
    glass.transmission = 1;
    const glm::vec3 through = straight_transmittance(glass, 1);
    const float open = 1 - 2 * 0.04f / 1.04f;  // both sides, and what goes between them
    EXPECT_FLOAT_EQ(through.x, 0.5f * open);
    EXPECT_FLOAT_EQ(through.y, 0.25f * open);
    const Bsdf bsdf(glass, 1);
    EXPECT_FALSE(bsdf.has_rough_lobe());
    const BsdfSample s = bsdf.sample({0, 0, 1}, 0.5f, {0.5f, 0.5f});
    EXPECT_EQ(s.kind, BsdfSample::Kind::straight);
    EXPECT_FLOAT_EQ(s.direction.z, -1);
}

TEST(Bsdf, PanesReflectByFresnelsEquationsOnBothSides) {
    for (const double index : {1.1, 1.33, 1.5, 2.4})
        for (const double angle : {0.0, 0.4, 0.9, 1.3, 1.55}) {
            // By angles, where the code goes by cosines; at normal incidence the two sides are one formula.
            const double inside = std::asin(std::sin(angle) / index);
            const double across =
                angle == 0 ? (index - 1) / (index + 1) : std::sin(angle - inside) / std::sin(angle + inside);
            const double along =
                angle == 0 ? (index - 1) / (index + 1) : std::tan(angle - inside) / std::tan(angle + inside);
            const double side = (across * across + along * along) / 2;
            // Out at once; or in, to and fro any odd number of times, and out.
            double pane = side, going = (1 - side) * (1 - side) * side;
            for (int i = 0; i < 200; ++i, going *= side * side)
                pane += going;
            EXPECT_NEAR(pane_reflectance(dielectric_f0(float(index)), float(std::cos(angle))), pane, 2e-5)
                << index << " " << angle;
        }
    EXPECT_EQ(pane_reflectance(0, 0.01f), 0);
    // The largest index that models are read with.
    EXPECT_NEAR(pane_reflectance(dielectric_f0(1000), 1), 2 * 0.996008 / 1.996008, 1e-4);
}

TEST(Bsdf, MirrorsGlassAndSharpMetalsAreSharp) {
    const auto is_sharp = [](const SurfaceParameters& p, float cosine) { return Bsdf(p, cosine).is_sharp(); };
    for (const float cosine : {1.0f, 0.7f, 0.4f}) {
        EXPECT_TRUE(is_sharp(metal(0), cosine));
        EXPECT_TRUE(is_sharp(metal(0.22f), cosine)) << "alpha 0.048";
        EXPECT_FALSE(is_sharp(metal(0.23f), cosine)) << "alpha 0.053";
        EXPECT_TRUE(is_sharp({glm::vec3(0.9f), 0, 0, 1, 0.04f}, cosine)) << "glass";
        EXPECT_FALSE(is_sharp(plastic(0, glm::vec3(0.5f)), cosine)) << "a coat over a diffuse base";
        EXPECT_FALSE(is_sharp(plastic(0.5f, glm::vec3(0)), cosine));
    }
    EXPECT_TRUE(is_sharp(plastic(0, glm::vec3(0)), 0.7f)) << "nothing but the coat";
    EXPECT_FALSE(is_sharp({glm::vec3(0), 1, 0, 0, 0}, 1.0f)) << "black sends nothing on";
    // By Schlick's formula the coat sends on 0.466 of 0.733 at this cosine, and 0.783 of 0.891 at the other.
    EXPECT_FALSE(is_sharp(plastic(0, glm::vec3(0.5f)), 0.15f)) << "share 0.64";
    EXPECT_TRUE(is_sharp(plastic(0, glm::vec3(0.5f)), 0.05f)) << "share 0.88";
}

TEST(Directions, PackedVectorsComeBack) {
    for (std::uint32_t i = 0; i < 10000; ++i) {
        Sampler random(i, 0);
        const glm::vec3 d =
            glm::normalize(glm::vec3(random.next_hashed(), random.next_hashed(), random.next_hashed()) - 0.5f);
        const glm::vec3 back = glm::normalize(unpack_direction(pack_direction(d)));
        EXPECT_LT(glm::length(back - d), 8e-5f);
    }
}

TEST(Directions, FramesAreOrthonormal) {
    for (const glm::vec3& n : {glm::vec3(0, 0, 1), glm::vec3(0, 0, -1), glm::normalize(glm::vec3(1, -2, -1e-8f))}) {
        const ShadingFrame frame(n);
        EXPECT_NEAR(glm::dot(frame.tangent, frame.bitangent), 0, 1e-6);
        EXPECT_NEAR(glm::dot(frame.tangent, n), 0, 1e-6);
        EXPECT_NEAR(glm::length(frame.to_world(glm::vec3(0.6f, 0, 0.8f))), 1, 1e-6);
        EXPECT_NEAR(glm::dot(glm::cross(frame.tangent, frame.bitangent), n), 1, 1e-6);
    }
}

}  // namespace

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

TEST(Sampler, EveryBitOfASeedIsSetHalfTheTime) {
    constexpr int count = 20000;
    for (int bit = 0; bit < 32; ++bit) {
        int set = 0;
        for (std::uint64_t i = 0; i < count; ++i)
            set += hash_bits(i * 2654435761u) >> bit & 1;
        EXPECT_NEAR(set, count / 2, 5 * std::sqrt(count) / 2) << bit;
    }
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
