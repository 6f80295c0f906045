// What mirrors and panes show, by the tracer: closed forms, and a second eye that looks for the same point.
#include "test_scene.h"

#include <equistream/virtual_image.h>

#include <glm/gtc/matrix_transform.hpp>

namespace equistream::embree_host {
namespace {

Material mirror() {
    Material m;
    m.base_colour = glm::vec3(1);
    m.metallic = 1;
    m.roughness = 0;
    m.double_sided = true;
    return m;
}

Material pane() {
    Material m;
    m.base_colour = glm::vec3(1);
    m.metallic = 0;
    m.roughness = 0;
    m.transmission = 1;
    m.index_of_refraction = 1.5f;
    m.double_sided = true;
    return m;
}

/// Upright, facing +Z, in the plane z.
glm::mat4 upright_at(float z) {
    return glm::translate(glm::mat4(1), glm::vec3(0, 0, z)) * glm::rotate(glm::mat4(1), pi_f / 2, glm::vec3(1, 0, 0));
}

glm::vec3 vector(const float (&v)[3]) {
    return {v[0], v[1], v[2]};
}

class SharpPath : public ::testing::Test {
protected:
    es_surface look(const glm::vec3& origin, const glm::vec3& direction) {
        if (!worker_)
            worker_.emplace(scene.build(moving));
        const std::vector<std::uint8_t> still(scene.model.instances.size(), 0);
        const NeighbourTransforms at_rest{{}, {}, still};
        const es_ray ray = make_ray(origin, direction);
        es_surface surface{};
        trace_surfaces(*worker_, {*scene.shading, moves.empty() ? at_rest : NeighbourTransforms{previous, next, moves}},
                       {&ray, 1}, {&surface, 1});
        return surface;
    }
    void add_wall(float z) { scene.add(floor_mesh(20, 20, scene.add_material(matte(glm::vec3(0.5f)))), upright_at(z)); }

    TestScene scene;
    std::vector<std::uint32_t> moving;
    std::vector<glm::mat4> previous, next;
    std::vector<std::uint8_t> moves;
    std::optional<Worker> worker_;  // from the first look on
};

TEST_F(SharpPath, WhatIsNotSharpShowsNothing) {
    add_wall(-2);
    EXPECT_EQ(look({0, 0, 0}, {0, 0, -1}).virtual_distance_m, 0);
    EXPECT_EQ(look({0, 0, 0}, {0, 0, 1}).virtual_distance_m, 0) << "a miss";
}

TEST_F(SharpPath, APlaneMirrorShowsItsMirrorImage) {
    scene.add(floor_mesh(3, 3, scene.add_material(mirror())), upright_at(-2));
    add_wall(5);
    for (const glm::vec3 direction : {glm::vec3(0, 0, -1), {0.3f, 0.1f, -1}, {-0.6f, 0.4f, -1}}) {
        const es_surface s = look({0.1f, 0.2f, 0.3f}, direction);
        EXPECT_EQ(s.specular, 1);
        // The wall at z = 5, mirrored in z = -2, is at z = -9.
        const float cosine = -glm::normalize(direction).z;
        EXPECT_NEAR(s.virtual_distance_m * cosine, 9.3f, 2e-5f);
        const glm::vec3 image = glm::vec3(0.1f, 0.2f, 0.3f) + s.virtual_distance_m * glm::normalize(direction);
        EXPECT_LT(glm::length(vector(s.virtual_next_m) - image), 3e-5f);
        EXPECT_LT(glm::length(vector(s.virtual_previous_m) - image), 3e-5f);
    }
}

TEST_F(SharpPath, TheSkyInAPlaneMirrorIsInfinitelyFar) {
    scene.add(floor_mesh(3, 3, scene.add_material(mirror())), upright_at(-2));
    EXPECT_EQ(look({0, 0, 0}, {0.2f, 0, -1}).virtual_distance_m, std::numeric_limits<float>::infinity());
}

TEST_F(SharpPath, ThroughPanesItIsThePathsLengthHoweverMany) {
    const std::uint32_t glass = scene.add_material(pane());
    for (const float z : {-1.0f, -1.5f, -2.25f})
        scene.add(floor_mesh(3, 3, glass), upright_at(z));
    add_wall(-6);
    const es_surface s = look({0, 0, 0}, {0.2f, 0.1f, -1});
    EXPECT_NEAR(s.distance_m, std::sqrt(1.05f), 1e-5f);
    EXPECT_NEAR(s.virtual_distance_m, 6 * std::sqrt(1.05f), 3e-5f);
    EXPECT_NEAR(s.virtual_next_m[2], -6, 3e-5f);
}

TEST_F(SharpPath, BetweenTwoMirrorsItEndsAfterEightSurfaces) {
    const std::uint32_t material = scene.add_material(mirror());
    scene.add(floor_mesh(9, 9, material), upright_at(-1));
    scene.add(floor_mesh(9, 9, material), upright_at(1));
    const es_surface s = look({0, 0, 0}, {0.02f, 0, -1});
    EXPECT_NEAR(s.virtual_distance_m, (1 + 2.0f * max_sharp_surfaces) * std::sqrt(1.0004f), 1e-3f);
}

TEST_F(SharpPath, ABallObeysTheMirrorEquation) {
    scene.add(ball_mesh(160, scene.add_material(mirror()), true), glm::translate(glm::mat4(1), glm::vec3(0, 0, -3)));
    add_wall(2);
    // Facets are flat between their vertices; where normals meet the axis they are the ball's.
    const es_surface s = look({0, 0, 0}, {0.001f, 0.0012f, -1});
    const float to_ball = 2, thing = 4, image = 1 / (2 + 1 / thing);
    EXPECT_NEAR(s.virtual_distance_m, to_ball + image, 0.02f);
    const es_surface sky = look({0, 0.4f, 0}, {0, 0.2f, -1});
    EXPECT_GT(sky.virtual_distance_m, sky.distance_m);
    EXPECT_LT(sky.virtual_distance_m, sky.distance_m + 1) << "even the sky is small and near in a ball";
}

TEST_F(SharpPath, WhatMovesInAMirrorMovesAsItsImageDoes) {
    scene.add(floor_mesh(3, 3, scene.add_material(mirror())), upright_at(-2));
    const std::uint32_t mover = scene.add(floor_mesh(1, 1, scene.add_material(matte(glm::vec3(0.5f)))), upright_at(3));
    moving = {mover};
    moves = {0, 1};
    const glm::vec3 back(-0.2f, 0.1f, 0.3f), on(0.25f, -0.1f, -0.4f);
    previous = {glm::mat4(1), glm::translate(glm::mat4(1), back) * upright_at(3)};
    next = {glm::mat4(1), glm::translate(glm::mat4(1), on) * upright_at(3)};
    const glm::vec3 direction = glm::normalize(glm::vec3(0.05f, -0.04f, -1));
    const es_surface s = look({0, 0, 0}, direction);
    const glm::vec3 image = s.virtual_distance_m * direction, mirrored(1, 1, -1);
    EXPECT_NEAR(image.z, -7, 2e-5f);
    EXPECT_LT(glm::length(vector(s.virtual_previous_m) - (image + back * mirrored)), 5e-5f);
    EXPECT_LT(glm::length(vector(s.virtual_next_m) - (image + on * mirrored)), 5e-5f);
}

/// A mirror that stands askew shows a wall with a point on it; wherever in a head box the other eye is, the ray to the
/// virtual point meets that same point of the wall by way of the mirror.
TEST_F(SharpPath, AnotherEyeSeesTheSamePointThroughTheVirtualOne) {
    scene.add(floor_mesh(4, 4, scene.add_material(mirror())),
              glm::translate(glm::mat4(1), glm::vec3(0.2f, 0, -2.5f)) *
                  glm::rotate(glm::mat4(1), 0.4f, glm::normalize(glm::vec3(0.3f, 1, 0))) *
                  glm::rotate(glm::mat4(1), pi_f / 2, glm::vec3(1, 0, 0)));
    add_wall(4);
    const glm::vec3 direction = glm::normalize(glm::vec3(0.1f, 0.05f, -1));
    const glm::vec3 image = look({0, 0, 0}, direction).virtual_distance_m * direction;
    const auto seen_in_mirror = [&](const glm::vec3& eye, const glm::vec3& towards) {
        const auto first = worker_->trace(eye, towards);
        const ShadingPoint p = scene.shading->surface_at(first.id, eye, towards, first.distance);
        const glm::vec3 from = offset_origin(p.position, p.geometric_normal, p.reach),
                        on = glm::reflect(towards, p.normal);
        return from + worker_->trace(from, on).distance * on;
    };
    const glm::vec3 thing = seen_in_mirror({0, 0, 0}, direction);
    for (int i = 0; i < 64; ++i) {
        Sampler random(static_cast<std::uint64_t>(i), 0);
        const glm::vec3 eye =
            0.5f * (glm::vec3(random.next_hashed(), random.next_hashed(), random.next_hashed()) - 0.5f);
        EXPECT_LT(glm::length(seen_in_mirror(eye, glm::normalize(image - eye)) - thing), 1e-3f)
            << "of 10 m, seen " << glm::length(image) << " m away: far below a quarter of a pixel";
    }
}

}  // namespace
}  // namespace equistream::embree_host
