/// What the conversion to Mitsuba XML computes itself; what Mitsuba makes of the files is tests/hosts's.
#include <scenes/mitsuba/lights.h>
#include <scenes/mitsuba/materials.h>

#include <gtest/gtest.h>

#include <cmath>
#include <complex>

namespace equistream::mitsuba_xml {
namespace {

/// Fresnel's equations with a complex index, as textbooks have them.
double reflectance(const ComplexIndex& index, double cosine) {
    const std::complex<double> n(index.eta, index.k), c(cosine, 0);
    const std::complex<double> inside = std::sqrt(1.0 - (1 - cosine * cosine) / (n * n));
    const double s = std::norm((c - n * inside) / (c + n * inside));
    const double p = std::norm((n * c - inside) / (n * c + inside));
    return 0.5 * (s + p);
}

TEST(SchlickConductor, FollowsSchlicksCurve) {
    for (const double f0 : {0.02, 0.2, 0.5, 0.8, 0.95}) {
        const ComplexIndex index = schlick_conductor(f0);
        EXPECT_NEAR(reflectance(index, 1), f0, 1e-6);
        double difference = 0, mean = 0;
        for (int i = 0; i < 1000; ++i) {
            const double cosine = (i + 0.5) / 1000;
            const double apart = reflectance(index, cosine) - (f0 + (1 - f0) * std::pow(1 - cosine, 5));
            difference = std::max(difference, std::abs(apart));
            mean += 2 * cosine * apart / 1000;
        }
        RecordProperty("worst at F0 " + std::to_string(f0), std::to_string(difference));
        EXPECT_LT(std::abs(mean), 0.01) << f0;
        EXPECT_LT(difference, 0.12) << f0;
    }
}

Mesh two_triangles(glm::vec2 low, glm::vec2 high) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    mesh.uvs = {low, {high.x, low.y}, high, {low.x, high.y}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
}

TEST(TexturedLight, IsSampledOnlyWhereItsMapIsOneToOne) {
    EXPECT_TRUE(maps_one_to_one(two_triangles({0, 0}, {1, 1})));
    EXPECT_TRUE(maps_one_to_one(two_triangles({0.25f, 1}, {0.5f, 0})));
    EXPECT_FALSE(maps_one_to_one(two_triangles({0, 0}, {2, 1})));
    EXPECT_FALSE(maps_one_to_one(two_triangles({0, 0}, {0, 1})));
    Mesh twice = two_triangles({0, 0}, {1, 1});
    twice.triangles.push_back({0, 1, 3});
    EXPECT_FALSE(maps_one_to_one(twice));
}

}  // namespace
}  // namespace equistream::mitsuba_xml
