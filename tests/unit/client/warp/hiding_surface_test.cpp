#include <client/warp/resample.h>
#include <tests/support/references/plain_engines.h>
#include <tests/unit/client/engine_scenes.h>
#include <tests/unit/evidence.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <ostream>
#include <random>

namespace equistream::test {
namespace {

constexpr DepthAgreement agreement{0.1f, 1e-3f};
/// The tolerance as samples have it: w over B.
constexpr float budget = agreement.tolerance / agreement.box_radius_m;

/// Of a function of column and row, 0 at the first of the inner four.
std::array<float, 16> sampled(const std::function<float(float, float)>& over_clearance) {
    std::array<float, 16> samples;
    for (int i = 0; i < 16; ++i)
        samples[std::size_t(i)] = over_clearance(float(i % 4 - 1), float(i / 4 - 1));
    return samples;
}

TEST(HidingSurface, APlaneHidesWhatLiesBehindItByMoreThanTwoBudgets) {
    // Steep: its samples are a hundred budgets apart.
    const auto plane = [](float x, float y) { return 1 + 100 * budget * x - 70 * budget * y; };
    std::mt19937 random(3);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int i = 0; i < 200; ++i) {
        const float s = uniform(random), t = uniform(random), here = plane(s, t);
        EXPECT_TRUE(surface_hides(agreement, sampled(plane), s, t, here - 2.01f * budget));
        EXPECT_FALSE(surface_hides(agreement, sampled(plane), s, t, here - 1.99f * budget));
        EXPECT_FALSE(surface_hides(agreement, sampled(plane), s, t, here)) << "on it";
        EXPECT_FALSE(surface_hides(agreement, sampled(plane), s, t, here + 50 * budget)) << "before it";
    }
}

TEST(HidingSurface, WhatBendsIsGivenWhatInterpolationMayBeOffBy) {
    // Second differences of two budgets along both axes.
    const auto bowl = [](float x, float y) { return 1 + budget * (x * x + y * y); };
    const float interpolated = 1 + budget, half = 0.5f;
    EXPECT_FALSE(surface_hides(agreement, sampled(bowl), half, half, interpolated - 3.9f * budget));
    EXPECT_TRUE(surface_hides(agreement, sampled(bowl), half, half, interpolated - 4.1f * budget));
    const auto bent = [](float x, float) { return 1 + 5 * budget * x * x; };
    EXPECT_FALSE(surface_hides(agreement, sampled(bent), half, half, 0)) << "bends too much to say anything";
    const auto twisted = [](float x, float y) { return 1 + 9 * budget * x * y; };
    EXPECT_FALSE(surface_hides(agreement, sampled(twisted), half, half, 0)) << "so does this";
}

/// The corner of a room, seen anywhere between samples: what lies in it is not hidden by what these interpolate to.
TEST(HidingSurface, ACreaseHidesNothingThatLiesInIt) {
    std::mt19937 random(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int i = 0; i < 500; ++i) {
        const float at = uniform(random), kink = 8 * budget * uniform(random), slope = budget * 40 * uniform(random);
        const auto corner = [&](float x, float) { return 1 + slope * x + kink * std::max(x - at, 0.0f); };
        for (const float s : {at, uniform(random)})
            EXPECT_FALSE(surface_hides(agreement, sampled(corner), s, uniform(random), corner(s, 0) - 1.99f * budget));
    }
}

TEST(HidingSurface, StepsAndUnknownSamplesHideNothing) {
    for (int i = 0; i < 16; ++i) {
        for (const float odd : {std::nanf(""), HUGE_VALF, 1 + 9 * budget}) {
            std::array<float, 16> samples;
            samples.fill(1);
            EXPECT_TRUE(surface_hides(agreement, samples, 0.5f, 0.5f, 0));
            samples[std::size_t(i)] = odd;
            EXPECT_FALSE(surface_hides(agreement, samples, 0.5f, 0.5f, 0)) << i << " " << odd;
        }
    }
}

/// A sphere's samples go round and over its poles; the same surface hides everywhere.
TEST(HidingSurface, GoesRoundTheSphere) {
    const EquirectCamera camera{32, 16, {}};
    const SourceGrid grid = source_grid(camera);
    FloatImage depth_m(32, 16, 1, 2.0f);
    const float behind = 1 / agreement.clearance(3), on_it = 1 / agreement.clearance(2);
    for (const int x : {-1, 0, 15, 30, 31})
        for (const int y : {-1, 0, 7, 14, 15}) {
            const int u = (x << position_bits) + 40, v = (y << position_bits) + 90;
            EXPECT_TRUE(surface_hides(agreement, grid, depth_m.view(), u, v, behind)) << x << " " << y;
            EXPECT_FALSE(surface_hides(agreement, grid, depth_m.view(), u, v, on_it)) << x << " " << y;
        }
    // Beyond the upper pole, above column 3, lie columns 18 and 19 of the first rows.
    depth_m.pixel(19, 1)[0] = 5;
    EXPECT_FALSE(surface_hides(agreement, grid, depth_m.view(), 3 << position_bits, -(1 << position_bits), behind));
    EXPECT_TRUE(surface_hides(agreement, grid, depth_m.view(), 10 << position_bits, -(1 << position_bits), behind));
}

}  // namespace

namespace {

/// Darker with distance: what lies behind a silhouette never looks as what is before it does.
glm::dvec3 dimmed(const glm::dvec3& p, double distance_m) {
    return smooth(p, 3) / (1 + (std::isinf(distance_m) ? 3 : 0.5 * distance_m));
}

/// How alike an engine's pictures are to its reference's, over several eyes.
struct Likeness {
    double squares = 0;
    std::int64_t samples = 0, gaps_of_both = 0, gaps_of_either = 0;

    void add(const EyePicture& fast, const EyePicture& plain) {
        for (int y = 0; y < fast.origin.height(); ++y)
            for (int x = 0; x < fast.origin.width(); ++x) {
                const bool gap = *fast.origin.pixel(x, y) == 0, reference_gap = *plain.origin.pixel(x, y) == 0;
                gaps_of_both += gap && reference_gap;
                gaps_of_either += gap || reference_gap;
                for (int c = 0; c < 3 && !gap && !reference_gap; ++c, ++samples)
                    squares += std::pow(fast.rgba.pixel(x, y)[c] - plain.rgba.pixel(x, y)[c], 2);
            }
    }
    double psnr_db() const { return 10 * std::log10(255.0 * 255 * double(samples) / std::max(squares, 1.0)); }
    double agreement_of_gaps() const { return double(gaps_of_both) / double(gaps_of_either); }
};

EyePicture seen_by(const char* engine_name, const SourceView& source, const EyeView& eye, bool reference) {
    // At the budget of everything else, which is tighter than the engines' own.
    const EngineOptions options{.source_depth_budget_px = default_error_budget_px};
    const auto engine = reference ? plain::make_engine(engine_name, options) : make_engine(engine_name, options);
    engine->set_source(source);
    EyePicture picture;
    engine->reproject(eye, picture);
    return picture;
}

/// What two ways to reckon the same may differ by where a sample lies on the very edge of a tolerance.
struct Expected {
    const char* engine;
    double min_psnr_db, min_agreement;

    friend std::ostream& operator<<(std::ostream& out, const Expected& expected) { return out << expected.engine; }
};

class FoundPictures : public testing::TestWithParam<Expected> {};

INSTANTIATE_TEST_SUITE_P(Client, FoundPictures,
                         testing::Values(Expected{"splat", 60, 0.97}, Expected{"mesh", 60, 0.97}),
                         [](const auto& test) { return std::string(test.param.engine); });

/// Depth alone would not tell whose colours a silhouette's pixels take.
TEST_P(FoundPictures, HaveTheReferencesColoursAndGaps) {
    const auto [engine, min_psnr_db, min_agreement] = GetParam();
    const SurfaceScene scene = furnished();
    const glm::dquat ahead = yaw_pitch(0.2, 0.1);
    for (const Camera& camera : engine_sources(360)) {
        const Rendered source = render(scene, dimmed, camera, Pose{{0.1, 0, 0}, ahead});
        Likeness gaps;
        for (const glm::dvec3& from : {glm::dvec3(0.1315, 0, 0), glm::dvec3(-0.063, 0, 0)}) {
            const EyeView eye{{120, 80, pi / 2}, {from, ahead}};
            const EyePicture fast = seen_by(engine, source.source(0.0315), eye, false);
            const EyePicture plain = seen_by(engine, source.source(0.0315), eye, true);
            Likeness colours;
            colours.add(fast, plain);
            gaps.add(fast, plain);
            EXPECT_GE(colours.psnr_db(), min_psnr_db)
                << camera.index() << " " << from.x << evidence(fast.rgb().view(), plain.rgb().view());
        }
        ASSERT_GT(gaps.gaps_of_either, 150) << camera.index();
        EXPECT_GE(gaps.agreement_of_gaps(), min_agreement) << camera.index();
    }
}

}  // namespace
}  // namespace equistream::test
