#include <equistream/error.h>

#include <client/warp/eye_rays.h>
#include <client/warp/resample.h>
#include <tests/support/references/plain_engines.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/evidence.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

const Distance nothing = [](const glm::dvec3&, const glm::dvec3&) { return infinity; };

ByteImage noise(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    ByteImage image(width, height, 3);
    for (std::uint8_t& sample : image.samples())
        sample = std::uint8_t(random());
    return image;
}

FloatImage smooth_view(const PerspectiveCamera& camera, const Pose& pose, double frequency) {
    FloatImage exact(camera.width, camera.height, 3);
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            const glm::dvec3 colour = smooth(pose.orientation * camera.direction(x + 0.5, y + 0.5), frequency);
            for (int c = 0; c < 3; ++c)
                exact.pixel(x, y)[c] = float(colour[c]);
        }
    return exact;
}

class EveryEngine : public testing::TestWithParam<std::tuple<std::string, bool>> {
protected:
    std::unique_ptr<Engine> engine() const {
        const auto& [name, reference] = GetParam();
        return reference ? plain::make_engine(name) : make_engine(name);
    }
};

INSTANTIATE_TEST_SUITE_P(Client, EveryEngine, testing::Combine(testing::Values("sphere", "surface"), testing::Bool()),
                         [](const auto& test) {
                             return std::get<0>(test.param) + (std::get<1>(test.param) ? "_reference" : "_fast");
                         });

TEST_P(EveryEngine, ReturnsItsInputForTheSourcesOwnView) {
    const PerspectiveCamera camera{64, 36, 1.3};
    const Pose pose{{1, 2, 3}, yaw_pitch(0.7, -0.2)};
    const ByteImage rgb = noise(64, 36, 1);
    const auto engine = this->engine();
    engine->set_source({.rgb = rgb.view(), .camera = camera, .pose = pose});
    EyePicture picture;
    engine->reproject({camera, pose}, picture);
    const ByteImage out = picture.rgb();
    EXPECT_TRUE(std::equal(out.samples().begin(), out.samples().end(), rgb.samples().begin()))
        << evidence(out.view(), rgb.view());
    EXPECT_EQ(picture.count(PixelOrigin::gap), 0);
}

/// Bilinear interpolation of f errs by at most (f_uu + f_vv) / 8 pixels squared; rounding to 8 bits by 1/510.
TEST_P(EveryEngine, RotationIsTheFunctionOfDirection) {
    const EquirectCamera sphere{512, 256, {}};
    const double frequency = 3;
    const auto colour = [&](const glm::dvec3& d, double) { return smooth(d, frequency); };
    const Rendered source = render(nothing, colour, sphere, {});
    const double step = sphere.pixel_angle_rad();
    const double second_derivative = 0.25 * 4 * frequency * frequency + 0.25 * 2 * frequency;
    const double bound = half_a_step + 1 / 510.0 + 2 * second_derivative * step * step / 8;
    const auto engine = this->engine();
    engine->set_source(source.source());
    const PerspectiveCamera camera{97, 61, pi / 2};
    for (const auto& [yaw, pitch] :
         {std::pair{0.0, 0.0}, {pi, 0.0}, {pi - 0.3, 0.4}, {0.3, pi / 2}, {2.0, -pi / 2}, {-1.0, 1.3}}) {
        const Pose pose{{0, 0, 0}, yaw_pitch(yaw, pitch) * glm::angleAxis(0.2, glm::dvec3(0, 0, 1))};
        EyePicture picture;
        engine->reproject({camera, pose}, picture);
        EXPECT_EQ(picture.count(PixelOrigin::source), 97 * 61);
        const FloatImage exact = smooth_view(camera, pose, frequency);
        EXPECT_LT(worst_difference(displayed(picture), exact), bound)
            << "yaw " << yaw << " pitch " << pitch << evidence(displayed(picture).view(), exact.view());
    }
}

TEST_P(EveryEngine, TurningPastAPerspectiveSourceLeavesGaps) {
    const PerspectiveCamera camera{80, 60, pi / 2};
    const ByteImage rgb = noise(80, 60, 2);
    const auto engine = this->engine();
    engine->set_source({.rgb = rgb.view(), .camera = camera, .pose = Pose{}});
    const Pose turned{{0, 0, 0}, yaw_pitch(pi / 4, 0)};
    EyePicture picture;
    engine->reproject({camera, turned}, picture);
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 80; ++x) {
            const glm::dvec2 p = camera.pixel(turned.orientation * camera.direction(x + 0.5, y + 0.5));
            const bool covered = p.x >= 0 && p.x <= 80 && p.y >= 0 && p.y <= 60;
            const bool at_edge =
                std::abs(p.x) < 0.1 || std::abs(p.x - 80) < 0.1 || std::abs(p.y) < 0.1 || std::abs(p.y - 60) < 0.1;
            if (!at_edge) {
                EXPECT_EQ(picture.origin.pixel(x, y)[0] != 0, covered) << x << "," << y;
            }
        }
    engine->reproject({camera, Pose{{0, 0, 0}, yaw_pitch(pi, 0)}}, picture);
    EXPECT_EQ(picture.count(PixelOrigin::gap), 80 * 60);
}

/// Noise shows most that positions are good to 1/32 of a sample (warp_test.cpp): 8 steps.
TEST(Rotation, FastEqualsReferenceOnNoise) {
    for (const Camera& camera :
         {Camera(EquirectCamera{256, 128, {}}), Camera(EquirectCamera{200, 90, {-1, 1.5, -0.7, 0.8}}),
          Camera(PerspectiveCamera{160, 100, 1.9})}) {
        const ByteImage rgb = noise(width_of(camera), height_of(camera), 3);
        const auto fast = make_engine("sphere");
        const auto reference = plain::make_engine("sphere");
        for (int i = 0; i < 12; ++i) {
            const Pose source{{0, 0, 0}, yaw_pitch(0.5 * i, 0.1 * i)};
            const EyeView eye{{120, 70, 1.5}, Pose{{0, 0, 0}, yaw_pitch(0.7 * i, 0.26 * i)}};
            EyePicture a, b;
            fast->set_source({.rgb = rgb.view(), .camera = camera, .pose = source});
            reference->set_source({.rgb = rgb.view(), .camera = camera, .pose = source});
            fast->reproject(eye, a);
            reference->reproject(eye, b);
            EXPECT_LT(worst_difference(displayed(a), displayed(b)), 8 * one_step)
                << evidence(a.rgb().view(), b.rgb().view());
            EXPECT_LE(std::abs(a.count(PixelOrigin::gap) - b.count(PixelOrigin::gap)), 1);
        }
    }
}

TEST(Engines, UnknownNamesListTheKnownOnes) {
    try {
        make_engine("spere");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("sphere"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find("eye-depth"), std::string::npos);
        EXPECT_NE(std::string(e.what()).find("'spere'"), std::string::npos);
    }
}

}  // namespace
}  // namespace equistream::test

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
        const SourceLookup lookup(camera);
        for (int i = 0; i < 200'000; ++i) {
            const glm::vec3 d{normal(random), normal(random), normal(random)};
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
    const SourceLookup sphere_lookup(sphere);
    const SourceLookup flat_lookup(flat);
    for (int y = 0; y < 18; ++y)
        for (int x = 0; x < 31; ++x) {
            const glm::vec3 a = sphere_lookup.unit_direction(x, y);
            const glm::vec3 b = flat_lookup.unit_direction(x, y);
            EXPECT_LT(glm::length(glm::dvec3(a.x, a.y, a.z) - sphere.direction(x + 0.5, y + 0.5)), 1e-6);
            EXPECT_LT(glm::length(glm::dvec3(b.x, b.y, b.z) - flat.direction(x + 0.5, y + 0.5)), 1e-6);
        }
}

TEST(Views, AreTheSameWhereEveryPixelLooksTheSameWay) {
    const EquirectCamera part{64, 32, {-1, 1.2, -0.5, 0.6}};
    EXPECT_TRUE(same_camera(part, part));
    for (double LongitudeLatitudeRange::*end :
         {&LongitudeLatitudeRange::longitude_min, &LongitudeLatitudeRange::longitude_max,
          &LongitudeLatitudeRange::latitude_min, &LongitudeLatitudeRange::latitude_max}) {
        EquirectCamera other = part;
        other.range.*end += 1e-6;
        EXPECT_FALSE(same_camera(part, other));
    }
    EXPECT_FALSE(same_camera(part, EquirectCamera{64, 30, part.range}));
    EXPECT_FALSE(same_camera(PerspectiveCamera{64, 32, 1}, PerspectiveCamera{64, 32, 1 + 1e-6}));
    const glm::dquat q = test::yaw_pitch(0.7, -0.2);
    EXPECT_TRUE(same_pose({{1, 2, 3}, q}, {{1, 2, 3}, -q}));
    EXPECT_TRUE(same_pose({{}, 0.9995 * q}, {{}, 0.9995 * q})) << "readers accept as much";
    EXPECT_FALSE(same_pose({{}, q}, {{}, q * glm::angleAxis(1e-6, glm::dvec3(0, 1, 0))}));
    EXPECT_FALSE(same_pose({{1, 2, 3}, q}, {{1, 2, 3.001}, q}));
}

}  // namespace
}  // namespace equistream
