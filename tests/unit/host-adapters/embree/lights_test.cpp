#include "test_scene.h"

#include <gtest/gtest.h>

namespace equistream::embree_host {
namespace {

Material lamp(const glm::vec3& radiance) {
    Material m = matte(glm::vec3(0));
    m.emission = radiance;
    return m;
}

TEST(Sun, ConeSamplesLieInTheDiscAndThePdfIsItsSolidAngle) {
    for (const float radius : {0.00465f, 0.1f, 1.5f}) {
        const SunLight sun({0.3f, 1, -0.2f}, glm::vec3(3), radius);
        const ShadingFrame frame(sun.towards);
        double cosines = 0;
        constexpr std::uint32_t n = 4096;
        for (std::uint32_t i = 0; i < n; ++i) {
            const glm::vec2 u = Sampler(3, i).pair(0, Sampler::Use::sun);
            const glm::vec3 local = sample_cone(u, sun.one_minus_cos);
            EXPECT_LE(std::acos(std::min(1.0f, local.z)), radius * 1.001f);
            cosines += local.z / sun.pdf / n;
        }
        // The irradiance on a plane facing the disc.
        EXPECT_NEAR(cosines * sun.radiance.x, 3, 0.003) << radius;
        EXPECT_TRUE(sun.contains(sun.towards));
        EXPECT_TRUE(sun.contains(frame.to_world({std::sin(0.98f * radius), 0, std::cos(0.98f * radius)})));
        EXPECT_FALSE(sun.contains(frame.to_world({std::sin(1.02f * radius), 0, std::cos(1.02f * radius)})));
    }
}

TEST(Emitters, TrianglesAreChosenByPowerAndPointsUniformly) {
    TestScene scene;
    const auto dim = scene.add_material(lamp(glm::vec3(1))), bright = scene.add_material(lamp(glm::vec3(5)));
    scene.add_material(matte(glm::vec3(0.5f)));
    scene.add(floor_mesh(1, 1, dim));
    // The same mesh twice as long and wide: the transform's area counts.
    scene.add(floor_mesh(1, 1, bright), glm::mat4(2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 2, 0, 10, 0, 0, 1));
    scene.build();
    const double total = 1 * 4 + 5 * 16;
    EXPECT_NEAR(scene.shading->material(dim).emission_pdf_area, 1 / total, 1e-7);
    EXPECT_NEAR(scene.shading->material(bright).emission_pdf_area, 5 / total, 1e-7);
    constexpr std::uint32_t n = 20000;
    int from_bright = 0;
    glm::dvec3 centre{0};
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler random(i, 0);
        const float choice = random.next_hashed();
        const EmitterSample s = scene.lights.emitters.sample(choice, {random.next_hashed(), random.next_hashed()});
        EXPECT_NEAR(s.normal.y, 1, 1e-6);
        if (s.material != bright)
            continue;
        ++from_bright;
        centre += glm::dvec3(s.position);
        EXPECT_NEAR(s.uv.x, (s.position.x - 8) / 4, 1e-5);
        EXPECT_NEAR(s.uv.y, (s.position.z + 2) / 4, 1e-5);
    }
    const double share = 80.0 / 84;
    EXPECT_NEAR(from_bright, n * share, 5 * std::sqrt(n * share * (1 - share)));
    centre /= from_bright;
    EXPECT_NEAR(centre.x, 10, 5 * 4 / std::sqrt(12.0 * n));
    EXPECT_NEAR(centre.z, 0, 5 * 4 / std::sqrt(12.0 * n));
}

TEST(Emitters, AliasTableServesManyUnequalTriangles) {
    TestScene scene;
    std::vector<std::uint32_t> materials;
    for (int i = 0; i < 40; ++i) {
        materials.push_back(scene.add_material(lamp(glm::vec3(static_cast<float>(1 + i % 7)))));
        scene.add(floor_mesh(0.5f, 0.5f * static_cast<float>(1 + i % 3), materials.back()));
    }
    scene.build();
    std::vector<double> counted(materials.size(), 0), expected;
    double total = 0;
    for (int i = 0; i < 40; ++i) {
        expected.push_back((1 + i % 7) * (1 + i % 3));
        total += expected.back();
    }
    constexpr std::uint32_t n = 200000;
    for (std::uint32_t i = 0; i < n; ++i)
        counted[scene.lights.emitters.sample((static_cast<float>(i) + 0.5f) / n, {0.3f, 0.3f}).material] += 1;
    for (std::size_t i = 0; i < counted.size(); ++i)
        EXPECT_NEAR(counted[i], n * expected[i] / total, 6) << i;
}

/// What a plane through the origin, facing up, gets from the samples of the table alone: mean and standard error.
std::pair<double, double> irradiance_by_table(const TestScene& scene) {
    constexpr std::uint32_t n = 200000;
    double sum = 0, squares = 0;
    for (std::uint32_t i = 0; i < n; ++i) {
        Sampler random(i, 0);
        const float choice = random.next_hashed();
        const EmitterSample s = scene.lights.emitters.sample(choice, {random.next_hashed(), random.next_hashed()});
        if (s.cut_away)
            continue;
        const ShadingMaterial& material = scene.shading->material(s.material);
        const double distance2 = glm::dot(s.position, s.position);
        const glm::vec3 d = s.position / static_cast<float>(std::sqrt(distance2));
        const double value =
            material.emission.y * d.y * -glm::dot(d, s.normal) / (material.emission_pdf_area * distance2);
        sum += value / n;
        squares += value * value / n;
    }
    return {sum, std::sqrt((squares - sum * sum) / n)};
}

TEST(Emitters, WhatAMaskCutsAwayGivesNoLight) {
    double seen[2];
    for (const bool masked : {false, true}) {
        TestScene scene;
        const std::uint32_t material = scene.add_material(lamp(glm::vec3(3)));
        if (masked) {
            scene.model.alpha_masks.push_back(checker_mask(64));
            scene.model.materials[material].alpha_mask = 0;
        }
        const glm::mat4 turned_over_above(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0.3f, 2, 0.2f, 1);
        scene.add(floor_mesh(1.5f, 1.5f, material), turned_over_above);
        scene.build();
        const auto [mean, error] = irradiance_by_table(scene);
        EXPECT_LT(error, 0.005 * mean);
        seen[masked] = mean;
    }
    EXPECT_NEAR(seen[1] / seen[0], 0.5, 0.01);
}

TEST(Emitters, AMeshWithoutTextureCoordinatesIsWholeForLightsAsForRays) {
    TestScene scene;
    const std::uint32_t material = scene.add_material(lamp(glm::vec3(3)));
    scene.model.alpha_masks.push_back(checker_mask(2));
    scene.model.materials[material].alpha_mask = 0;
    Mesh mesh = floor_mesh(1, 1, material);
    mesh.uvs.clear();
    scene.add(mesh);
    scene.build();
    for (std::uint32_t i = 0; i < 100; ++i) {
        Sampler random(i, 0);
        EXPECT_FALSE(scene.lights.emitters.sample(0.5f, {random.next_hashed(), random.next_hashed()}).cut_away);
    }
}

}  // namespace
}  // namespace equistream::embree_host
