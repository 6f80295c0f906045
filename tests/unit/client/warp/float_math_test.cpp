#include <client/warp/eye_rays.h>
#include <client/warp/resample.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream {
namespace {

TEST(FloatMath, ArcTangentIsWithinItsStatedError) {
    double worst = 0;
    for (int i = 0; i < 2'000'000; ++i) {
        const double angle = -pi + 2 * pi * (i + 0.5) / 2'000'000;
        const float x = float(std::cos(angle));
        const float y = float(std::sin(angle));
        worst = std::max(worst, std::abs(double(formulas::fast_atan2(y, x)) - std::atan2(double(y), double(x))));
    }
    EXPECT_LT(worst, 4e-7);
}

TEST(FloatMath, ArcTangentOnTheAxesAndOfNothing) {
    EXPECT_EQ(formulas::fast_atan2(0, 0), 0);
    EXPECT_FLOAT_EQ(formulas::fast_atan2(0, -1), float(pi));
    EXPECT_FLOAT_EQ(formulas::fast_atan2(-1, 0), -float(pi) / 2);
    EXPECT_TRUE(std::isnan(formulas::fast_atan2(std::nanf(""), 1)));
    EXPECT_TRUE(std::isnan(formulas::fast_atan2(1, std::nanf(""))));
}

/// A hundredth of a pixel on the widest sphere anybody reads, against the double-precision contract.
TEST(SourceLookup, PositionsAgreeWithTheContract) {
    std::mt19937 random(7);
    std::normal_distribution<float> normal;
    EquirectCamera partial{2000, 900, {-1.0, 2.2, -0.9, 0.7}};
    for (const EquirectCamera& camera : {EquirectCamera{6032, 3016, {}}, partial}) {
        const EquirectLookup lookup(camera);
        for (int i = 0; i < 200'000; ++i) {
            const Vec3f d{normal(random), normal(random), normal(random)};
            const PixelPosition p = lookup.project(d);
            const glm::dvec2 exact = camera.pixel({d.x, d.y, d.z});
            const bool covered = exact.x > 0 && exact.y > 0 && exact.x < camera.width && exact.y < camera.height;
            if (!covered)
                continue;
            EXPECT_LT(std::abs(shortest_column_difference(p.u - exact.x, camera.width, camera.range)), 0.01);
            EXPECT_NEAR(p.v, exact.y, 0.01);
            EXPECT_TRUE(lookup.contains(p));
        }
    }
}

TEST(SourceLookup, UnitDirectionsAreThoseOfPixelCentres) {
    const EquirectCamera sphere{37, 20, {}};
    const PerspectiveCamera flat{31, 18, 1.2};
    const EquirectLookup sphere_lookup(sphere);
    const PerspectiveLookup flat_lookup(flat);
    for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 31; ++x) {
            const Vec3f a = sphere_lookup.unit_direction(x, y);
            const Vec3f b = flat_lookup.unit_direction(x, y);
            EXPECT_LT(glm::length(glm::dvec3(a.x, a.y, a.z) - sphere.direction(x + 0.5, y + 0.5)), 1e-6);
            EXPECT_LT(glm::length(glm::dvec3(b.x, b.y, b.z) - flat.direction(x + 0.5, y + 0.5)), 1e-6);
        }
}

}  // namespace
}  // namespace equistream
