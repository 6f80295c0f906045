#include "test_scene.h"

#include <equistream/conventions.h>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <functional>
#include <random>

namespace equistream::embree_host {
namespace {

constexpr LongitudeLatitudeRange full_sphere;

/// An image whose pixels are a function of their centres' directions.
FloatImage painted(int width, int height, const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
    FloatImage image(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto d = equirect_direction(PixelCoordinates<double>{x + 0.5, y + 0.5}, width, height, full_sphere);
            const glm::dvec3 value = radiance({d.x, d.y, d.z});
            for (int c = 0; c < 3; ++c)
                image.pixel(x, y)[c] = static_cast<float>(value[c]);
        }
    return image;
}

FloatImage noise(int width, int height, std::uint32_t seed) {
    std::mt19937 random(seed);
    std::exponential_distribution<double> bright(1);
    // Powers of what is exponentially distributed: a few pixels hold most of the light; some hold none.
    FloatImage image = painted(width, height, [&](const glm::dvec3&) {
        const double v = std::pow(bright(random), 4);
        return v < 0.01 ? glm::dvec3(0) : glm::dvec3(v, 0.5 * v, 2 * v);
    });
    image.pixel(0, 0)[0] = 1;
    return image;
}

glm::vec3 uniform_direction(std::mt19937& random) {
    std::uniform_real_distribution<float> unit(0, 1);
    const float y = 2 * unit(random) - 1, longitude = 2 * pi_f * unit(random), r = std::sqrt(1 - y * y);
    return {r * std::cos(longitude), y, r * std::sin(longitude)};
}

glm::vec3 turned(double radians, const glm::vec3& d) {
    return glm::mat3(glm::rotate(glm::dmat4(1), radians, glm::dvec3(0, 1, 0))) * d;
}

/// A white matte square whose front faces `normal`, and what the eye sees of it.
MeanRadiance plane_under_sky(FloatImage image, double rotation_rad, const glm::vec3& normal, bool next_event,
                             int pixels = 64) {
    TestScene scene;
    const ShadingFrame frame(normal);
    scene.add(floor_mesh(10, 10, scene.add_material(matte(glm::vec3(1)))),
              glm::mat4(glm::vec4(frame.bitangent, 0), glm::vec4(normal, 0), glm::vec4(frame.tangent, 0),
                        glm::vec4(0, 0, 0, 1)));
    scene.lights.sky_image.emplace(std::move(image), rotation_rad, glm::vec3(1));
    scene.options.max_bounces = 1;
    scene.options.next_event = next_event;
    const glm::vec3 eye = 2.0f * normal + 0.5f * frame.tangent;
    return scene.look(eye, -eye, pixels);
}

TEST(SkyImage, DensityIntegratesToOneAndBelongsToTheSamples) {
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 1}, {1, 4}, {7, 5}, {64, 32}, {333, 101}}) {
        const SkyLight sky(noise(width, height, 5), 0.7, glm::vec3(1, 2, 3));
        ASSERT_FALSE(sky.is_black());
        double integral = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const auto d = equirect_direction(
                    PixelCoordinates<float>{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f}, width, height,
                    full_sphere);
                integral +=
                    sky.pdf(turned(0.7, {d.x, d.y, d.z})) * equirect_pixel_solid_angle(y, width, height, full_sphere);
            }
        EXPECT_NEAR(integral, 1, 1e-5) << width << "x" << height;
        int elsewhere = 0;
        for (std::uint32_t i = 0; i < 4096; ++i) {
            const SkySample s = sky.sample(Sampler(11, i).pair(0, Sampler::Use::sky));
            ASSERT_GT(s.pdf, 0);
            ASSERT_NEAR(glm::length(s.direction), 1, 1e-5);
            // A direction on a pixel's edge may be rounded into its neighbour.
            elsewhere += std::abs(sky.pdf(s.direction) / s.pdf - 1) > 1e-4f || sky.radiance(s.direction) != s.radiance;
        }
        EXPECT_LT(elsewhere, 8) << width << "x" << height;
    }
}

TEST(SkyImage, SamplesAndUniformDirectionsGiveTheSameIrradiance) {
    const SkyLight sky(noise(37, 19, 8), -2.1, glm::vec3(0.5f));
    const glm::vec3 normal = glm::normalize(glm::vec3(0.3f, 0.8f, -0.4f));
    std::mt19937 random(3);
    struct Sums {
        double mean = 0, squares = 0;
    } sampled, uniform;
    constexpr std::uint32_t n = 400000;
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler numbers(i, 0);
        const SkySample s = sky.sample({numbers.next_hashed(), numbers.next_hashed()});
        const double a = s.radiance.y * std::max(0.0f, glm::dot(s.direction, normal)) / s.pdf;
        const glm::vec3 d = uniform_direction(random);
        const double b = sky.radiance(d).y * std::max(0.0f, glm::dot(d, normal)) * 4 * pi;
        sampled.mean += a / n, sampled.squares += a * a / n;
        uniform.mean += b / n, uniform.squares += b * b / n;
    }
    const double variance =
        (sampled.squares - sampled.mean * sampled.mean + uniform.squares - uniform.mean * uniform.mean) / n;
    EXPECT_LT(std::sqrt(variance), 0.02 * uniform.mean) << "too noisy to tell anything";
    EXPECT_NEAR(sampled.mean, uniform.mean, 4 * std::sqrt(variance));
}

TEST(SkyImage, AGradientLightsPlanesAsItsClosedFormSays) {
    // Radiance 1 + a.d gives a plane facing n the irradiance pi + 2 pi/3 a.n.
    const glm::dvec3 a(0.5, -0.3, 0.6);
    const FloatImage image = painted(256, 128, [&](const glm::dvec3& d) { return glm::dvec3(1 + glm::dot(a, d)); });
    for (const double rotation : {0.0, 1.0})
        for (const glm::vec3& n : {glm::vec3(0, 1, 0), glm::vec3(0, -1, 0), glm::vec3(1, 0, 0), glm::vec3(0, 0, -1),
                                   glm::vec3(0, 0, 1), glm::normalize(glm::vec3(1, 2, -3))})
            for (const bool next_event : {true, false}) {
                const MeanRadiance seen = plane_under_sky(image, rotation, n, next_event);
                const double expected = 1 + 2.0 / 3 * glm::dot(glm::dvec3(turned(rotation, a)), glm::dvec3(n));
                EXPECT_NEAR(seen.mean.y, expected, 4 * seen.standard_error + 1e-4)
                    << n.x << " " << n.y << " " << n.z << ", next event " << next_event << ", turned by " << rotation;
            }
}

TEST(SkyImage, AConstantOneIsAFurnaceToo) {
    for (const float roughness : {0.0f, 0.4f, 1.0f})
        for (const bool metal : {false, true}) {
            TestScene scene;
            Material white = matte(glm::vec3(1));
            white.index_of_refraction = 1.5f;
            white.metallic = metal ? 1 : 0;
            white.roughness = roughness;
            scene.add(ball_mesh(32, scene.add_material(white), true));
            scene.lights.sky_image.emplace(FloatImage(64, 32, 3, 1.0f), 0.3, glm::vec3(1));
            scene.options.max_bounces = 64;
            for (const float x : {0.0f, 0.5f, 0.85f}) {
                const MeanRadiance seen = scene.look({x, 0.1f, 5}, {0, 0, -1});
                EXPECT_NEAR(seen.mean.y, 1, 4 * seen.standard_error + 0.01) << roughness << " " << metal << " at " << x;
            }
        }
}

TEST(SkyImage, ATinySunInItConverges) {
    constexpr int width = 512, height = 256, row = 60, column = 300;
    FloatImage image(width, height, 3, 0.1f);
    const double sun_sr = equirect_pixel_solid_angle(row, width, height, full_sphere);
    for (int c = 0; c < 3; ++c)
        image.pixel(column, row)[c] = static_cast<float>(5 / sun_sr);
    const auto sun = equirect_direction(PixelCoordinates<double>{column + 0.5, row + 0.5}, width, height, full_sphere);
    const MeanRadiance seen = plane_under_sky(image, 0, {0, 1, 0}, true, 256);
    const double expected = 0.1 + (5 - 0.1 * sun_sr) * sun.y / pi;
    EXPECT_NEAR(seen.mean.y, expected, 4 * seen.standard_error + 1e-4 * expected);
    // 64 samples a pixel, 256 pixels: a pixel's own error is 16 times this. Scattered rays alone would hit the sun with
    // one sample in 6,000 and be wrong by some 150 percent.
    EXPECT_LT(16 * seen.standard_error, 0.02 * expected);
}

TEST(SkyImage, WithAndWithoutNextEventEstimationAgreeOnGlossAndShadow) {
    for (const float roughness : {0.2f, 0.5f}) {
        MeanRadiance seen[2];
        for (const bool next_event : {false, true}) {
            TestScene scene;
            Material floor = matte({0.5f, 0.4f, 0.3f});
            floor.metallic = 0.5f;
            floor.index_of_refraction = 1.5f;
            floor.roughness = roughness;
            scene.add(floor_mesh(10, 10, scene.add_material(floor)));
            scene.add(ball_mesh(16, scene.add_material(matte(glm::vec3(0.7f))), true),
                      glm::translate(glm::mat4(1), glm::vec3(1.5f, 1, -1)));
            scene.lights.sky_image.emplace(noise(24, 12, 4), 0.4, glm::vec3(1));
            scene.options.max_bounces = 4;
            scene.options.next_event = next_event;
            seen[next_event] = scene.look({0, 1.5f, 3}, {0, -1.5f, -3}, next_event ? 512 : 4096);
        }
        EXPECT_TRUE(same_mean(seen[0], seen[1])) << roughness;
    }
}

TEST(SkyImage, StandsWhereTheConventionSaysAndTurnsAboutUp) {
    FloatImage image(8, 4, 3);
    const auto paint = [&](int x, int y, float value) { image.pixel(x, y)[1] = value; };
    paint(3, 1, 1), paint(4, 1, 1);  // ahead
    paint(5, 1, 2), paint(6, 1, 2);  // to the right
    paint(7, 1, 3), paint(0, 1, 3);  // behind, across the seam
    const auto at = [&](double rotation, const glm::vec3& d) {
        return SkyLight(image, rotation, glm::vec3(1, 10, 1)).radiance(glm::normalize(d + glm::vec3(0, 0.2f, 0))).y;
    };
    EXPECT_EQ(at(0, {0.1f, 0, -1}), 10);
    EXPECT_EQ(at(0, {1, 0, 0.1f}), 20);
    EXPECT_EQ(at(0, {0.1f, 0, 1}), 30);
    EXPECT_EQ(at(0, {-0.1f, 0, 1}), 30);
    EXPECT_EQ(at(0, {-1, 0, 0.1f}), 0);
    // A quarter turn about +Y takes ahead to the left.
    EXPECT_EQ(at(pi / 2, {-1, 0, 0.1f}), 10);
    EXPECT_EQ(at(pi / 2, {0.1f, 0, -1}), 20);
}

TEST(SkyImage, WhatIsLookedAtIsFilteredAcrossSeamAndPolesAndByTheCone) {
    FloatImage image(16, 8, 3);
    for (int y = 0; y < 8; ++y)
        image.pixel(15, y)[1] = 4;
    for (int x = 0; x < 8; ++x)
        image.pixel(x, 0)[1] = 8;
    const SkyLight sky(image, 0, glm::vec3(1));
    const auto mean = [&](const glm::vec3& d, float spread) {
        double sum = 0;
        constexpr std::uint32_t n = 40000;
        for (std::uint32_t i = 0; i < n; ++i) {
            Sampler numbers(i, 1);
            sum += sky.filtered(d, spread, {numbers.next_hashed(), numbers.next_hashed(), numbers.next_hashed()}).y / n;
        }
        return sum;
    };
    EXPECT_NEAR(mean({0, 0, 1}, 0), 2, 0.05) << "the seam lies between 4 and 0";
    EXPECT_NEAR(mean(glm::normalize(glm::vec3(1e-4f, 1, -1e-4f)), 0), 4, 0.1) << "half the pole's row is bright";
    double everything = 0;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x)
            everything += image.pixel(x, y)[1] * equirect_pixel_solid_angle(y, 16, 8, full_sphere) / (4 * pi);
    EXPECT_NEAR((mean({0.6f, 0, 0.8f}, 100) + mean({-0.6f, 0, 0.8f}, 100)) / 2, everything, 0.02);
    TestScene scene;
    scene.add(floor_mesh(1, 1, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.lights.sky_image.emplace(FloatImage(4, 2, 3, 3.0f), 0, glm::vec3(2));
    EXPECT_NEAR(scene.look({0, 1, 0}, {0, 1, 0}, 4).mean.x, 6, 1e-5);
}

TEST(SkyImage, ABlackOneGivesNothing) {
    const SkyLight sky(FloatImage(5, 3, 3), 0, glm::vec3(1));
    EXPECT_TRUE(sky.is_black());
    EXPECT_EQ(sky.pdf({0, 1, 0}), 0);
    EXPECT_EQ(plane_under_sky(FloatImage(5, 3, 3), 0, {0, 1, 0}, true, 4).mean, glm::dvec3(0));
}

/// A box from -1 to 1 whose ceiling has a square hole around its middle.
void add_room(TestScene& scene, const Material& wall, float half_hole) {
    const std::uint32_t material = scene.add_material(wall);
    const auto add_side = [&](const glm::vec3& inwards) {
        const ShadingFrame frame(inwards);
        scene.add(floor_mesh(1, 1, material), glm::mat4(glm::vec4(frame.bitangent, 0), glm::vec4(inwards, 0),
                                                        glm::vec4(frame.tangent, 0), glm::vec4(-inwards, 1)));
    };
    for (const glm::vec3& n :
         {glm::vec3(0, 1, 0), glm::vec3(1, 0, 0), glm::vec3(-1, 0, 0), glm::vec3(0, 0, 1), glm::vec3(0, 0, -1)})
        add_side(n);
    const float half_frame = 0.5f * (1 - half_hole), middle = 0.5f * (1 + half_hole);
    for (const float side : {-1.0f, 1.0f}) {
        scene.add(floor_mesh(half_frame, 1, material), glm::translate(glm::mat4(1), glm::vec3(side * middle, 1, 0)));
        scene.add(floor_mesh(half_hole, half_frame, material),
                  glm::translate(glm::mat4(1), glm::vec3(0, 1, side * middle)));
    }
}

const std::vector<glm::vec3> eyes{{0, -0.3f, 0}, {0.3f, -0.2f, 0.2f}};

/// An eighth of what arrives in the room is the sky's.
TEST(Openings, AFurnaceWithAHoleIsOneEverywhere) {
    TestScene scene;
    Material wall = matte(glm::vec3(0.9f));
    wall.emission = glm::vec3(0.1f);
    add_room(scene, wall, 0.3f);
    scene.lights.sky = glm::vec3(1);
    scene.options.max_bounces = 200;
    scene.openings = learn_openings(scene.build(), eyes, 2);
    ASSERT_GT(scene.openings.cells(), 0u);
    for (const glm::vec3& direction :
         {glm::vec3(0.3f, -1, 0.1f), glm::vec3(1, 0.2f, 0.3f), glm::vec3(-0.2f, 0.4f, 1)}) {
        const MeanRadiance seen = scene.look({0.1f, -0.2f, 0.2f}, direction, 1024);
        // One path in 2,000 is cut off after 64 surfaces.
        EXPECT_NEAR(seen.mean.y, 1, 4 * seen.standard_error + 5e-4) << direction.x;
        EXPECT_LT(seen.standard_error, 0.002);
    }
}

enum class SkyKind { constant, image };

/// With a glossy ball in it and a pane in the hole.
MeanRadiance look_into_room(SkyKind kind, bool next_event, bool learn, const glm::vec3& direction) {
    TestScene scene;
    add_room(scene, matte({0.5f, 0.6f, 0.7f}), 0.2f);
    Material gloss = matte(glm::vec3(0.6f)), pane = matte({1, 0.8f, 1});
    gloss.index_of_refraction = pane.index_of_refraction = 1.5f;
    gloss.roughness = 0.4f;
    pane.transmission = 0.5f;
    scene.add(ball_mesh(16, scene.add_material(gloss), true),
              glm::translate(glm::mat4(1), glm::vec3(0.3f, -0.7f, -0.4f)) * glm::scale(glm::mat4(1), glm::vec3(0.3f)));
    scene.add(floor_mesh(0.2f, 0.2f, scene.add_material(pane)), glm::translate(glm::mat4(1), glm::vec3(0, 1, 0)));
    if (kind == SkyKind::constant)
        scene.lights.sky = {3, 4, 5};
    else
        scene.lights.sky_image.emplace(
            painted(16, 8, [](const glm::dvec3& d) { return glm::dvec3(4 + 3 * d.x, 5 + 4 * d.z, 6); }), 0.3,
            glm::vec3(1));
    scene.options.unbiased = true;
    scene.options.next_event = next_event;
    if (learn) {
        scene.openings = learn_openings(scene.build(), eyes, 2);
        EXPECT_GT(scene.openings.cells(), 0u);
    }
    return scene.look({0.1f, -0.2f, 0.2f}, direction, next_event ? 1024 : 8192);
}

TEST(Openings, ARoomWithASmallHoleIsAsBruteForceHasIt) {
    for (const SkyKind kind : {SkyKind::constant, SkyKind::image})
        for (const glm::vec3& direction : {glm::vec3(0.3f, -1, 0.1f), glm::vec3(0.2f, -0.5f, -0.6f)}) {
            const MeanRadiance learned = look_into_room(kind, true, true, direction);
            const MeanRadiance brute = look_into_room(kind, false, false, direction);
            EXPECT_TRUE(same_mean(learned, brute)) << static_cast<int>(kind) << " " << direction.x;
        }
}

TEST(Openings, SkylightThroughASmallHoleHasLessThanAFifthOfItsVariance) {
    const MeanRadiance learned = look_into_room(SkyKind::constant, true, true, {0.3f, -1, 0.1f});
    const MeanRadiance unlearned = look_into_room(SkyKind::constant, true, false, {0.3f, -1, 0.1f});
    EXPECT_NEAR(learned.mean.y, unlearned.mean.y, 4 * unlearned.standard_error);
    EXPECT_LT(std::pow(learned.standard_error / unlearned.standard_error, 2), 1.0 / 5);
}

TEST(Openings, ALidThatMovesOverTheHoleAfterwardsCostsNoLight) {
    MeanRadiance seen[2];
    for (const bool next_event : {false, true}) {
        TestScene scene;
        add_room(scene, matte(glm::vec3(0.6f)), 0.3f);
        scene.lights.sky = glm::vec3(4);
        scene.options.next_event = next_event;
        scene.openings = learn_openings(scene.build(), eyes, 2);
        scene.add(floor_mesh(0.2f, 0.3f, 0), glm::translate(glm::mat4(1), glm::vec3(0.12f, 1.01f, 0)));
        seen[next_event] = scene.look({0.1f, -0.2f, 0.2f}, {0.3f, -1, 0.1f}, next_event ? 512 : 4096);
    }
    EXPECT_TRUE(same_mean(seen[0], seen[1]));
}

TEST(Openings, WhatIsLearnedDoesNotDependOnThreads) {
    TestScene scene;
    add_room(scene, matte(glm::vec3(0.6f)), 0.3f);
    scene.lights.sky = glm::vec3(4);
    const TracedScene& traced = scene.build();
    const SkyOpenings one = learn_openings(traced, eyes, 1), five = learn_openings(traced, eyes, 5);
    ASSERT_GT(one.cells(), 0u);
    EXPECT_EQ(one.cells(), five.cells());
    EXPECT_EQ(one.gain(), five.gain());
    std::mt19937 random(6);
    std::uniform_real_distribution<float> unit(0, 1);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 at = glm::vec3(2 * unit(random), 2 * unit(random), 2 * unit(random)) - 1.0f;
        const glm::vec3 normal = uniform_direction(random);
        const OpeningList a = one.at(at, normal).list, b = five.at(at, normal).list;
        ASSERT_EQ(a.empty(), b.empty());
        const glm::vec2 u(unit(random), unit(random));
        if (!a.empty()) {
            EXPECT_EQ(a.sample(at, u), b.sample(at, u));
        }
    }
}

TEST(Openings, UnderAnOpenSkyThereAreNone) {
    TestScene scene;
    scene.add(floor_mesh(50, 50, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.add(ball_mesh(16, 0, true), glm::translate(glm::mat4(1), glm::vec3(0, 1, -3)));
    scene.lights.sky = glm::vec3(1);
    EXPECT_TRUE(learn_openings(scene.build(), std::vector<glm::vec3>{{0, 1.6f, 0}}, 2).empty());
}

}  // namespace
}  // namespace equistream::embree_host
