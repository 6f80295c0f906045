#include "test_scene.h"

#include <equistream/conventions.h>

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include <numeric>

namespace equistream::embree_host {
namespace {

/// A mean agrees with a value when it lies within four standard errors (and a rounding allowance).
void expect_mean(const MeanRadiance& seen, double expected, const char* what) {
    EXPECT_NEAR(seen.mean.y, expected, 4 * seen.standard_error + 2e-5 * expected) << what;
}

Material white_material(const char* kind) {
    Material m = matte(glm::vec3(1));
    m.name = kind;
    const std::string k = kind;
    m.index_of_refraction = 1.5f;
    if (k == "metal" || k == "mirror")
        m.metallic = 1;
    if (k == "metal")
        m.roughness = 0.4f;
    if (k == "mirror" || k == "glass")
        m.roughness = 0;
    if (k == "glass")
        m.transmission = 1;
    return m;
}

TEST(Furnace, AWhiteBallUnderAWhiteSkyDisappears) {
    for (const char* kind : {"matte", "metal", "mirror", "glass"}) {
        TestScene scene;
        scene.add(ball_mesh(32, scene.add_material(white_material(kind)), true));
        scene.lights.sky = glm::vec3(1);
        scene.options.max_bounces = 64;
        for (const float x : {0.0f, 0.5f, 0.85f}) {
            const MeanRadiance seen = scene.look({x, 0.1f, 5}, {0, 0, -1});
            // The albedo table's error allowance; shading normals of the ball's rim lose what falls below the facets.
            EXPECT_NEAR(seen.mean.y, 1, 4 * seen.standard_error + 0.01) << kind << " at " << x;
        }
    }
}

TEST(Furnace, AClosedRoomThatEmitsHalfAndReflectsHalfIsOneEverywhere) {
    TestScene scene;
    Material wall = matte(glm::vec3(0.5f));
    wall.emission = glm::vec3(0.5f);
    scene.add(ball_mesh(24, scene.add_material(wall), false));
    scene.options.max_bounces = 200;
    expect_mean(scene.look({0.1f, 0.2f, 0.3f}, {0.3f, -0.5f, 1}), 1, "with next-event estimation");
    scene.options.next_event = false;
    expect_mean(scene.look({0.1f, 0.2f, 0.3f}, {0.3f, -0.5f, 1}), 1, "without");
}

TEST(Furnace, UnbiasedOrNotWhiteThingsBesideEachOtherDisappear) {
    for (const bool unbiased : {false, true})
        for (const char* kind : {"metal", "mirror", "glass"}) {
            TestScene scene;
            scene.add(ball_mesh(32, scene.add_material(white_material("matte")), true));
            scene.add(ball_mesh(32, scene.add_material(white_material(kind)), true),
                      glm::translate(glm::mat4(1), glm::vec3(2, 0, 0)));
            scene.lights.sky = glm::vec3(1);
            scene.options.max_bounces = 64;
            scene.options.unbiased = unbiased;
            const MeanRadiance seen = scene.look({0.7f, 0, 5}, {0, 0, -1}, 512);  // matte first, then the other
            EXPECT_NEAR(seen.mean.y, 1, 4 * seen.standard_error + 0.01) << kind << ", unbiased " << unbiased;
        }
}

/// A floor beside a wall that reaches as far as it matters, under a wide sun that shines on both.
MeanRadiance floor_beside(const Material& wall, bool unbiased) {
    TestScene scene;
    scene.add(floor_mesh(50, 50, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.add(floor_mesh(200, 200, scene.add_material(wall)),
              glm::rotate(glm::mat4(1), -pi_f / 2, glm::vec3(0, 0, 1)));  // in the plane x = 0, facing +x
    scene.lights.sun.emplace(glm::vec3(1, 1, 0), glm::vec3(4), 0.2f);
    scene.options.unbiased = unbiased;
    return scene.look({1, 1, 0.3f}, {0, -1, 0}, 4096);
}

TEST(Unbiased, SunlightOffAMirrorDoublesThatOnTheFloorBesideIt) {
    const MeanRadiance seen = floor_beside(white_material("mirror"), true);
    const double direct = 0.5 / pi * 4 * std::sqrt(0.5);
    EXPECT_LT(seen.standard_error, 0.01 * direct);
    EXPECT_NEAR(seen.mean.y, 2 * direct, 4 * seen.standard_error + 0.005 * direct);
}

TEST(Unbiased, SunlightOffGlassIsThereAndDroppedByDefault) {
    const double direct = 0.5 / pi * 4 * std::sqrt(0.5);
    const MeanRadiance dropped = floor_beside(white_material("glass"), false);
    EXPECT_NEAR(dropped.mean.y, direct, 4 * dropped.standard_error + 0.002 * direct);
    const MeanRadiance kept = floor_beside(white_material("glass"), true);
    const double pane = 0.095673;  // at 45 degrees and index 1.5, both sides
    EXPECT_NEAR(kept.mean.y, direct * (1 + pane), 4 * kept.standard_error + 0.002 * direct);
    EXPECT_GT(kept.mean.y, direct + 4 * kept.standard_error + 0.01 * direct);
}

TEST(Direct, SunOnAMattePlaneIsAlbedoOverPiTimesIrradianceTimesCosine) {
    TestScene scene;
    scene.add(floor_mesh(10, 10, scene.add_material(matte({0.6f, 0.3f, 0.1f}))));
    scene.options.max_bounces = 1;
    for (const float elevation : {0.3f, 0.8f, 1.5f}) {
        scene.lights.sun.emplace(glm::vec3(std::cos(elevation), std::sin(elevation), 0), glm::vec3(4, 5, 6), 0.00465f);
        const MeanRadiance seen = scene.look({0, 2, 1}, {0, -2, -1}, 32);
        EXPECT_NEAR(seen.mean.x, 0.6 / pi * 4 * std::sin(elevation), 2e-3) << elevation;
        EXPECT_NEAR(seen.mean.y, 0.3 / pi * 5 * std::sin(elevation), 2e-3) << elevation;
        EXPECT_NEAR(seen.mean.z, 0.1 / pi * 6 * std::sin(elevation), 2e-3) << elevation;
    }
}

/// Exporters write them, and smoothing over both sides of a card leaves them.
TEST(Direct, NormalsWithoutADirectionAreTheTriangles) {
    TestScene scene;
    Mesh floor = floor_mesh(10, 10, scene.add_material(matte(glm::vec3(0.6f))));
    floor.normals.assign(floor.positions.size(), glm::vec3(0));
    scene.add(std::move(floor));
    scene.options.max_bounces = 1;
    scene.lights.sun.emplace(glm::vec3(0.3f, 1, 0), glm::vec3(4), 0.00465f);
    const double cosine = 1 / std::sqrt(1.09);
    EXPECT_NEAR(scene.look({0, 2, 1}, {0, -2, -1}, 32).mean.y, 0.6 / pi * 4 * cosine, 2e-3);
}

/// Its disc's part above the horizon, whichever way its middle lies: as without asking for the sun.
TEST(Direct, AWideSunThatHasHalfSetStillShines) {
    TestScene scene;
    scene.add(floor_mesh(10, 10, scene.add_material(matte(glm::vec3(0.6f)))));
    scene.options.max_bounces = 1;
    scene.lights.sun.emplace(glm::vec3(1, -0.1f, 0), glm::vec3(4), 0.5f);
    const MeanRadiance seen = scene.look({0, 2, 1}, {0, -2, -1}, 4096);
    scene.options.next_event = false;
    const MeanRadiance by_chance = scene.look({0, 2, 1}, {0, -2, -1}, 16384);
    EXPECT_GT(seen.mean.y, 0.01);
    EXPECT_NEAR(seen.mean.y, by_chance.mean.y, 4 * (seen.standard_error + by_chance.standard_error));
}

/// A point's error grows with the way of the ray that found it, and the plane's own coordinate is 0.
TEST(Direct, APlaneSeenFromFarAboveDoesNotShadeItself) {
    TestScene scene;
    scene.add(floor_mesh(4000, 4000, scene.add_material(matte(glm::vec3(0.6f)))));
    scene.options.max_bounces = 1;
    scene.lights.sun.emplace(glm::vec3(0.3f, 1, 0.2f), glm::vec3(4), 0.00465f);
    const double near_y = scene.look({3, 2, 1}, {0.3f, -2, -1}, 32).mean.y;
    for (const float height_m : {200.0f, 800.0f, 1600.0f})
        for (int i = 0; i < 64; ++i) {
            const glm::vec3 from(37.3f * float(i), height_m, -11.9f * float(i));
            const glm::vec3 towards(std::sin(0.1f * float(i)), -1, 0.013f * float(i));
            EXPECT_NEAR(scene.look(from, towards, 32).mean.y, near_y, 0.01 * near_y) << height_m << ' ' << i;
        }
}

TEST(Direct, SunBelowThePlaneGivesNothing) {
    TestScene scene;
    scene.add(floor_mesh(10, 10, scene.add_material(matte(glm::vec3(0.6f)))));
    scene.lights.sun.emplace(glm::vec3(1, -0.1f, 0), glm::vec3(4), 0.00465f);
    EXPECT_EQ(scene.look({0, 2, 1}, {0, -2, -1}, 8).mean, glm::dvec3(0));
}

/// A floor lit by a horizontal square above it.
void add_lit_floor(TestScene& scene, const Material& floor, float half_side, float height, float radiance) {
    scene.add(floor_mesh(50, 50, scene.add_material(floor)));
    Material lamp = matte(glm::vec3(0));
    lamp.emission = glm::vec3(radiance);
    lamp.double_sided = false;
    // Turned over: its front faces down.
    scene.add(floor_mesh(half_side, half_side, scene.add_material(lamp)),
              glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0, height, 0)), pi_f, glm::vec3(1, 0, 0)));
    scene.options.max_bounces = 1;
}

/// Form factor from a point to a parallel square centred above it (four corner rectangles; Howell C-4).
double square_form_factor(double half_side, double height) {
    const double x = half_side / height, r = std::sqrt(1 + x * x);
    return 4 / (2 * pi) * (2 * x / r * std::atan(x / r));
}

TEST(Direct, SquareLampAboveAMatteFloorHasItsFormFactor) {
    for (const float half_side : {0.05f, 1.0f, 4.0f}) {
        TestScene scene;
        Material floor = matte(glm::vec3(0.5f));
        add_lit_floor(scene, floor, half_side, 2, 3);
        expect_mean(scene.look({0.5f, 1, 0.5f}, {-0.5f, -1, -0.5f}), 0.5 * 3 * square_form_factor(half_side, 2),
                    "square lamp");
    }
}

/// Light samples and scattered rays must agree on what the mask leaves: a sample that takes a hole for a lamp makes the
/// floor too bright, whatever its weight.
TEST(Direct, AHalfCutAwayLampGivesHalfItsLightHoweverItIsFound) {
    for (const bool next_event : {true, false}) {
        TestScene scene;
        add_lit_floor(scene, matte(glm::vec3(0.5f)), 1.5f, 2, 3);
        scene.model.alpha_masks.push_back(checker_mask(64));
        scene.model.materials[1].alpha_mask = 0;
        scene.options.next_event = next_event;
        const MeanRadiance seen = scene.look({0.5f, 1, 0.5f}, {-0.5f, -1, -0.5f}, next_event ? 512 : 2048);
        const double half = 0.5 * 0.5 * 3 * square_form_factor(1.5, 2);
        EXPECT_LT(seen.standard_error, 0.01 * half) << next_event;
        EXPECT_NEAR(seen.mean.y, half, 4 * seen.standard_error + 0.002 * half) << next_event;
    }
}

TEST(Direct, TheBackOfASingleSidedLampIsDark) {
    TestScene scene;
    add_lit_floor(scene, matte(glm::vec3(0.5f)), 1, 2, 3);
    EXPECT_EQ(scene.look({0, 5, 0}, {0, -1, 0}, 4).mean, glm::dvec3(0));
    EXPECT_EQ(scene.look({0, 1, 0}, {0, 1, 0}, 4).mean, glm::dvec3(3));
}

TEST(Estimators, WithAndWithoutNextEventEstimationAgree) {
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
        MeanRadiance seen[2];
        for (const bool next_event : {false, true}) {
            TestScene scene;
            Material floor = matte({0.5f, 0.4f, 0.3f});
            floor.metallic = 0.5f;
            floor.index_of_refraction = 1.5f;
            floor.roughness = roughness;
            add_lit_floor(scene, floor, 1.5f, 2, 3);
            scene.lights.sun.emplace(glm::vec3(0.6f, 0.5f, -0.6f), glm::vec3(1), 0.2f);
            scene.lights.sky = glm::vec3(0.2f);
            Material ball = matte(glm::vec3(0.7f));
            scene.add(ball_mesh(16, scene.add_material(ball), true),
                      glm::translate(glm::mat4(1), glm::vec3(1.5f, 1, -1)));
            scene.options.max_bounces = 4;
            scene.options.next_event = next_event;
            seen[next_event] = scene.look({0, 1.5f, 3}, {0, -1.5f, -3}, next_event ? 512 : 4096);
        }
        EXPECT_TRUE(same_mean(seen[0], seen[1])) << roughness;
    }
}

TEST(Glass, APaneDimsSunAndLampAlikeForShadowRaysAndScattering) {
    for (const bool next_event : {false, true}) {
        TestScene scene;
        add_lit_floor(scene, matte(glm::vec3(0.5f)), 1, 2, 3);
        Material pane = white_material("glass");
        pane.base_colour = glm::vec3(1, 0.5f, 1);
        scene.add(floor_mesh(50, 50, scene.add_material(pane)), glm::translate(glm::mat4(1), glm::vec3(0, 1, 0)));
        scene.options.next_event = next_event;
        scene.options.max_bounces = 1;
        // Straight down from the middle Fresnel varies little over the lamp; bounds by its extremes.
        const MeanRadiance seen = scene.look({0.3f, 0.5f, 0.3f}, {-0.3f, -0.5f, -0.3f}, next_event ? 256 : 2048);
        const double open = 0.5 * 3 * square_form_factor(1, 2) * 0.5;
        EXPECT_LT(seen.mean.y, open * 0.9231 + 4 * seen.standard_error) << next_event;
        EXPECT_GT(seen.mean.y, open * 0.9023 - 4 * seen.standard_error) << next_event;
    }
}

TEST(Glass, OpaqueThingsBehindAPaneStillCastShadows) {
    TestScene scene;
    scene.add(floor_mesh(10, 10, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.add(floor_mesh(10, 10, scene.add_material(white_material("glass"))),
              glm::translate(glm::mat4(1), glm::vec3(0, 1, 0)));
    scene.add(floor_mesh(1, 1, 0), glm::translate(glm::mat4(1), glm::vec3(0, 2, 0)));
    scene.lights.sun.emplace(glm::vec3(0, 1, 0), glm::vec3(4), 0.00465f);
    scene.options.max_bounces = 1;
    EXPECT_EQ(scene.look({0.3f, 0.5f, 0.3f}, {-0.3f, -0.5f, -0.3f}, 8).mean, glm::dvec3(0));
    EXPECT_GT(scene.look({3.3f, 0.5f, 0.3f}, {-0.3f, -0.5f, -0.3f}, 8).mean.y, 0.5);
}

TEST(Mirror, ShowsTheSunsDiscAndALampUndimmed) {
    TestScene scene;
    Material floor = white_material("mirror");
    floor.base_colour = glm::vec3(0.5f);
    add_lit_floor(scene, floor, 1, 2, 3);
    // Schlick at 45 degrees on F0 = 1/2.
    const double fresnel = 0.5 + 0.5 * std::pow(1 - std::sqrt(0.5), 5);
    EXPECT_NEAR(scene.look({-1, 1, 0}, {1, -1, 0}, 4).mean.y, 0, 1e-9);  // passes beside the lamp
    EXPECT_NEAR(scene.look({-2, 2, 0}, {1, -1, 0}, 4).mean.y, 0, 1e-9);
    EXPECT_NEAR(scene.look({-1.9f, 1, 0}, {1, -1, 0}, 4).mean.y, 0, 1e-9);
    EXPECT_NEAR(scene.look({-2.5f, 1, 0.2f}, {1, -1, 0}, 4).mean.y, fresnel * 3, 1e-3);  // half way to its edge
    scene.lights.sun.emplace(glm::vec3(1, 1, 0), glm::vec3(0.001f), 0.00465f);
    EXPECT_NEAR(scene.look({-6, 1, 0}, {1, -1, 0}, 4).mean.y, fresnel * scene.lights.sun->radiance.y, 1e-3);
}

TEST(Paths, MissesSeeTheSkyAndHaveNoCoverage) {
    TestScene scene;
    scene.add(floor_mesh(1, 1, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.lights.sky = {0.1f, 0.2f, 0.3f};
    Worker worker(scene.build());
    const std::vector<es_ray> rays{make_ray({0, 1, 0}, {0, 1, 0}), make_ray({0, 1, 0}, {0, -1, 0})};
    const std::vector<std::uint64_t> seeds{1, 2};
    std::vector<float> rgba(8);
    worker.trace_radiance(rays, seeds, 0, rgba);
    EXPECT_FLOAT_EQ(rgba[0], 0.1f);
    EXPECT_FLOAT_EQ(rgba[2], 0.3f);
    EXPECT_EQ(rgba[3], 0);
    EXPECT_EQ(rgba[7], 1);
}

/// The denoiser's guides are those of the first rough thing, tinted by the mirrors before it; ids those of the first.
TEST(Paths, GuidesLookThroughMirrorsAndIdsDoNot) {
    TestScene scene;
    scene.add(floor_mesh(5, 5, scene.add_material(matte({0.6f, 0.3f, 0.1f}))));
    Material mirror = white_material("mirror");
    mirror.base_colour = glm::vec3(0.5f);
    scene.add(floor_mesh(1, 1, scene.add_material(mirror)), glm::translate(glm::mat4(1), glm::vec3(0, 2, 0)));
    scene.lights.sky = {0.2f, 3, 0.4f};
    Worker worker(scene.build());
    const std::vector<es_ray> rays{make_ray({3, 1, 0}, {0, -1, 0}), make_ray({3, 1, 0}, {0, 1, 0}),
                                   make_ray({0, 1, 0}, {0, 1, 0})};
    const std::vector<std::uint64_t> seeds{1, 2, 3};
    std::vector<float> rgba(12), guides(18);
    std::vector<std::uint32_t> ids(6, 9);
    worker.trace_radiance(rays, seeds, 0, rgba, guides, ids);
    const std::vector<float> expected{0.6f, 0.3f, 0.1f, 0, 1, 0, 0.2f, 1, 0.4f, 0, 0, 0, 0.3f, 0.15f, 0.05f, 0, 1, 0};
    for (std::size_t i = 0; i < guides.size(); ++i)
        EXPECT_NEAR(guides[i], expected[i], 1e-3) << i;
    EXPECT_EQ(ids, (std::vector<std::uint32_t>{1, 1, 0, 0, 2, 2}));
}

TEST(Paths, ThoseThatAreNotFiniteAreCounted) {
    TestScene scene;
    scene.add(floor_mesh(10, 10, scene.add_material(matte(glm::vec3(0)))));
    scene.lights.sky = glm::vec3(0, INFINITY, 0);
    Worker worker(scene.build());
    const std::vector<es_ray> rays{make_ray({0, 1, 0}, {0, 1, 0}), make_ray({0, 1, 0}, {0, -1, 0}),
                                   make_ray({0, 1, 0}, {1, 0, 0})};
    std::vector<float> rgba(12);
    worker.trace_radiance(rays, std::vector<std::uint64_t>{1, 2, 3}, 0, rgba);
    EXPECT_EQ(worker.counts().not_finite, 2u);  // the black floor gives nothing
}

TEST(Paths, AnAnswerDependsOnItsRayAloneNotOnTheBatch) {
    TestScene scene;
    scene.add(floor_mesh(5, 5, scene.add_material(matte(glm::vec3(0.5f)))));
    scene.add(ball_mesh(8, 0, true), glm::translate(glm::mat4(1), glm::vec3(0, 1, 0)));
    scene.lights.sky = glm::vec3(0.4f);
    scene.lights.sun.emplace(glm::vec3(1, 2, 1), glm::vec3(2), 0.01f);
    const TracedScene& traced = scene.build();
    std::vector<es_ray> rays;
    for (int i = 0; i < 50; ++i)
        rays.push_back(make_ray({0, 2, 5}, {0.02f * static_cast<float>(i) - 0.5f, -0.3f, -1}));
    std::vector<std::uint64_t> seeds(rays.size());
    std::iota(seeds.begin(), seeds.end(), 100);
    std::vector<float> together(rays.size() * 4), alone(4);
    Worker first(traced), second(traced);
    first.trace_radiance(rays, seeds, 5, together);
    for (std::size_t i = rays.size(); i-- > 0;) {
        second.trace_radiance(std::span(rays).subspan(i, 1), std::span(seeds).subspan(i, 1), 5, alone);
        EXPECT_EQ(together[4 * i + 1], alone[1]) << i;
    }
}

TEST(Surfaces, InsideABallOfRadiusREverySurfaceIsAtR) {
    TestScene scene;
    constexpr int n = 96;
    constexpr float radius = 3;
    scene.add(ball_mesh(n, scene.add_material(matte({0.2f, 0.4f, 0.8f})), false),
              glm::scale(glm::mat4(1), glm::vec3(radius)));
    Worker worker(scene.build());
    std::vector<es_ray> rays;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        Sampler random(i, 0);
        rays.push_back(
            make_ray(glm::vec3(0), glm::vec3(random.next_hashed(), random.next_hashed(), random.next_hashed()) - 0.5f));
    }
    std::vector<es_surface> surfaces(rays.size());
    const std::vector<std::uint8_t> still(1, 0);
    trace_surfaces(worker, {*scene.shading, {{}, {}, still}}, rays, surfaces);
    for (std::size_t i = 0; i < rays.size(); ++i) {
        EXPECT_LE(surfaces[i].distance_m, radius * 1.00001f);
        // Quadrilateral cells are cut along a diagonal: half of it is the farthest a chord reaches from a vertex.
        EXPECT_GE(surfaces[i].distance_m, radius * std::cos(pi_f / n / std::sqrt(2.0f)) * 0.99999f);
        float cosine = 0;
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(surfaces[i].position_previous_m[c], rays[i].direction[c] * surfaces[i].distance_m, 1e-5);
            cosine -= surfaces[i].normal[c] * rays[i].direction[c];
        }
        EXPECT_GT(cosine, 0.99f);
        EXPECT_FLOAT_EQ(surfaces[i].albedo[2], 0.8f);
        EXPECT_EQ(surfaces[i].object_id, 1u);
        EXPECT_EQ(surfaces[i].material_id, 1u);
        EXPECT_EQ(surfaces[i].instance_id, 1u);
    }
}

TEST(Surfaces, AMissIsInfinitelyFarAndOtherwiseZero) {
    TestScene scene;
    scene.add(floor_mesh(1, 1, scene.add_material(matte(glm::vec3(0.5f)))));
    Worker worker(scene.build());
    const std::vector<es_ray> rays{make_ray({0, 1, 0}, {0, 1, 0})};
    es_surface surface{};
    surface.object_id = 7;
    const std::vector<std::uint8_t> still(1, 0);
    trace_surfaces(worker, {*scene.shading, {{}, {}, still}}, rays, {&surface, 1});
    EXPECT_EQ(surface.distance_m, std::numeric_limits<float>::infinity());
    EXPECT_EQ(surface.object_id, 0u);
    EXPECT_EQ(surface.normal[1], 0);
}

TEST(Surfaces, TextureCoordinatesAreThoseOfThePlaceAndTheirDensityThatOfTheInstance) {
    TestScene scene;
    const std::uint32_t material = scene.add_material(matte(glm::vec3(0.5f)));
    scene.add(floor_mesh(1, 2, material));
    scene.add(floor_mesh(1, 2, material), glm::scale(glm::translate(glm::mat4(1), glm::vec3(9, 0, 0)), glm::vec3(2)));
    scene.build();
    const auto at = [&](std::uint32_t instance, std::uint32_t triangle, float u, float v) {
        return scene.shading->surface_at({instance, triangle, u, v}, {0, 1, 0}, {0, -1, 0}, 1);
    };
    EXPECT_NEAR(at(0, 0, 0.5f, 0.25f).uv_per_metre, std::sqrt(1 / 8.0f), 1e-5f);
    EXPECT_NEAR(at(1, 0, 0.5f, 0.25f).uv_per_metre, std::sqrt(1 / 32.0f), 1e-5f);
    const glm::vec2 uv = at(0, 0, 0.5f, 0.25f).uv;  // a quarter of (0, 0), half of (1, 1), a quarter of (1, 0)
    EXPECT_NEAR(uv.x, 0.75f, 1e-6f);
    EXPECT_NEAR(uv.y, 0.5f, 1e-6f);
}

TEST(Surfaces, MovingInstancesSayWhereTheyWereAndWillBe) {
    TestScene scene;
    const std::uint32_t material = scene.add_material(matte(glm::vec3(0.5f)));
    scene.add(floor_mesh(20, 20, material), glm::translate(glm::mat4(1), glm::vec3(0, -1, 0)));
    const std::uint32_t mover = scene.add(floor_mesh(1, 1, material));
    Worker worker(scene.build({mover}));
    const std::vector<glm::mat4> previous{glm::mat4(1), glm::translate(glm::mat4(1), glm::vec3(-0.5f, 0, 0))};
    const std::vector<glm::mat4> next{glm::mat4(1), glm::rotate(glm::mat4(1), pi_f / 2, glm::vec3(0, 1, 0))};
    const std::vector<std::uint8_t> moves{0, 1};
    const std::vector<es_ray> rays{make_ray({0.25f, 3, 0}, {0, -1, 0}), make_ray({5, 3, 0}, {0, -1, 0})};
    std::vector<es_surface> surfaces(2);
    trace_surfaces(worker, {*scene.shading, {previous, next, moves}}, rays, surfaces);
    EXPECT_NEAR(surfaces[0].position_previous_m[0], -0.25, 1e-6);
    EXPECT_NEAR(surfaces[0].position_next_m[0], 0, 1e-6);
    EXPECT_NEAR(surfaces[0].position_next_m[2], -0.25, 1e-6);
    EXPECT_NEAR(surfaces[1].position_previous_m[0], 5, 1e-6);
    EXPECT_NEAR(surfaces[1].position_next_m[1], -1, 1e-6);
}

}  // namespace
}  // namespace equistream::embree_host
