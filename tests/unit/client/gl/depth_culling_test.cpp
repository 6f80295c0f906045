#include "gl_fixture.h"
#include "gl_scene.h"

#include <client/depth/gl/depth_pass.h>

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

/// Balls behind a wall, beside it, before it, and behind a fence whose every second plank is cut away.
SceneModel hall() {
    SceneModel model;
    model.materials.resize(2);
    model.materials[1].alpha_mask = 0;
    model.alpha_masks.push_back({2, 1, Wrap::repeat, Wrap::repeat, {0, 255}});
    add_square(model, "wall", 3, {-3.2, 0, -4}, 0);
    add_square(model, "fence", 3, {3.2, 0, -4}, 1);
    for (glm::vec2& uv : model.meshes.back().uvs)
        uv *= 9.0f;
    std::mt19937 random(3);
    std::uniform_real_distribution<float> unit(-1, 1);
    for (int i = 0; i < 300; ++i)
        add_ball(model, {6 * unit(random), 2.5f * unit(random), -8 + 3 * unit(random)}, 0.5f + 0.3f * unit(random), 8);
    for (int i = 0; i < 9; ++i)
        add_ball(model, {4 * unit(random), 2 * unit(random), -2.5f}, 0.2f, 8);
    return model;
}

/// Two eyes and a sphere's view among them, on a walk with a jump in its middle.
std::array<gl::DepthViewpoint, 3> views_at(int step) {
    const double along = 0.1 * step, jump = step < 6 ? 0 : 0.8;
    const glm::dquat turn = yaw_pitch(0.3 * along - jump, 0.1 * along);
    const glm::dvec3 head(jump - along, 0.2 * along, 0.3 * along);
    return {gl::DepthViewpoint{{300, 180, pi / 2}, {head + turn * glm::dvec3(-0.03, 0, 0), turn}},
            gl::DepthViewpoint{{300, 180, pi / 2}, {head + turn * glm::dvec3(0.03, 0, 0), turn}},
            gl::DepthViewpoint{{270, 233, 1.8}, {{0, 0, 0}, turn}}};
}

std::vector<float> samples_of(const gl::DepthPass& pass, int layer, const PerspectiveCamera& camera) {
    std::vector<float> samples(std::size_t(camera.width) * std::size_t(camera.height));
    glGetTextureSubImage(pass.texture(), 0, 0, 0, layer, camera.width, camera.height, 1, GL_DEPTH_COMPONENT, GL_FLOAT,
                         GLsizei(samples.size() * sizeof(float)), samples.data());
    return samples;
}

class GlDepthCulling : public Gl {};

/// Bit for bit, from the first draw on and whatever moves: views, instances and what hides others.
TEST_F(GlDepthCulling, LeavesDepthAsItIs) {
    const SceneModel model = hall();
    gl::DepthPass everything(model), outside(model), hidden(model);
    std::vector<glm::mat4> transforms;
    for (const Instance& instance : model.instances)
        transforms.push_back(instance.world_from_object);
    for (int step = 0; step < 12; ++step) {
        transforms[0][3].x += 0.15f;  // the wall slides aside
        for (gl::DepthPass* pass : {&everything, &outside, &hidden})
            pass->set_transforms(transforms);
        const auto views = views_at(step);
        everything.draw(views, gl::Culling::nothing);
        outside.draw(views, gl::Culling::outside);
        hidden.draw(views, gl::Culling::hidden);
        for (int layer = 0; layer < 3; ++layer) {
            const PerspectiveCamera& camera = views[std::size_t(layer)].camera;
            const std::vector<float> expected = samples_of(everything, layer, camera);
            EXPECT_EQ(samples_of(outside, layer, camera), expected) << step << ' ' << layer;
            EXPECT_EQ(samples_of(hidden, layer, camera), expected) << step << ' ' << layer;
        }
    }
}

/// Half of the balls cannot be seen.
TEST_F(GlDepthCulling, WhatIsBehindAWallIsNotDrawn) {
    const SceneModel model = hall();
    gl::DepthPass pass(model);
    const auto views = views_at(0);
    pass.draw(views, gl::Culling::nothing);
    EXPECT_EQ(pass.drawn().triangles, 3 * pass.triangle_count());
    pass.draw(views, gl::Culling::outside);
    const std::uint32_t before = pass.drawn().triangles;
    for (int i = 0; i < 3; ++i)
        pass.draw(views, gl::Culling::hidden);
    const std::uint32_t after = pass.drawn().triangles;
    EXPECT_LT(after, before * 2 / 3);
    EXPECT_GT(after, before / 5);
    pass.draw(views, gl::Culling::hidden);
    EXPECT_EQ(pass.drawn().triangles, after);
}

}  // namespace
}  // namespace equistream::test
