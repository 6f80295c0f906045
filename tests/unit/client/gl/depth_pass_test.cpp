#include "gl_fixture.h"
#include "gl_scene.h"

#include <client/depth/gl/depth_pass.h>
#include <client/depth/gl/scene_geometry.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

/// Radial distances of a layer's corner that a view fills.
FloatImage downloaded(const gl::DepthPass& pass, int layer, const PerspectiveCamera& camera) {
    FloatImage depth_m(camera.width, camera.height, 1);
    glGetTextureSubImage(pass.texture(), 0, 0, 0, layer, camera.width, camera.height, 1, GL_DEPTH_COMPONENT, GL_FLOAT,
                         GLsizei(depth_m.samples().size_bytes()), depth_m.samples().data());
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x) {
            float& sample = depth_m.pixel(x, y)[0];
            const glm::dvec3 ray = camera.direction(x + 0.5, y + 0.5);
            sample = float(1 / (double(sample) * double(gl::DepthPass::inverse_scale()) * -ray.z));
        }
    return depth_m;
}

/// Share of pixels that are off by more than `allowed`, relatively; misses agree with misses.
double share_off(const FloatImage& depth_m, const Distance& distance, const gl::DepthViewpoint& view, double allowed) {
    int off = 0;
    for (int y = 0; y < depth_m.height(); ++y)
        for (int x = 0; x < depth_m.width(); ++x) {
            const double expected =
                distance(view.pose.position_m, view.pose.orientation * view.camera.direction(x + 0.5, y + 0.5));
            const double found = double(depth_m.pixel(x, y)[0]);
            off += std::isinf(expected) ? !std::isinf(found) : !(std::abs(found / expected - 1) <= allowed);
        }
    return off / double(depth_m.samples().size());
}

const std::array<gl::DepthViewpoint, 3> views = {
    gl::DepthViewpoint{{320, 200, pi / 2}, {{-0.03, 0, 0}, {1, 0, 0, 0}}},
    gl::DepthViewpoint{{320, 200, pi / 2}, {{0.2, -0.1, 0.3}, yaw_pitch(0.4, -0.2)}},
    gl::DepthViewpoint{{150, 240, 1.2}, {{0, 0, 0.5}, yaw_pitch(-0.5, 0.3)}}};

class GlDepthPass : public Gl {};

TEST_F(GlDepthPass, ViewsOfAnySizeHaveTheDistancesOfTheirRays) {
    gl::DepthPass pass(ball_and_square());
    pass.draw(views);
    EXPECT_EQ(pass.size(), (gl::Size{320, 256}));
    for (std::size_t i = 0; i < views.size(); ++i) {
        const FloatImage depth_m = downloaded(pass, int(i), views[i].camera);
        // Corners lie on the ball, its facets within r (1 - cos(pi / 120)) of it; the outline is a pixel wide.
        EXPECT_LT(share_off(depth_m, ball_and_square_m, views[i], 3e-3), 0.004) << i;
        EXPECT_LT(share_off(depth_m, ball_and_square_m, views[i], 1e-5), 0.2) << i;
    }
}

TEST_F(GlDepthPass, MovedInstancesAreWhereTheyWerePut) {
    const SceneModel model = ball_and_square();
    gl::DepthPass pass(model);
    std::vector<glm::mat4> transforms = {model.instances[0].world_from_object, model.instances[1].world_from_object};
    transforms[0][3] += glm::vec4(-0.7f, 0.1f, 0.4f, 0);
    pass.set_transforms(transforms);
    pass.draw(views);
    const auto moved = [](const glm::dvec3& o, const glm::dvec3& d) {
        const double ball = to_sphere(o, d, glm::vec3(-0.4f, 0.3f, -1.6f), 0.5);
        const double wall = to_plane(o, d, {0, 0, 1}, -4);
        const glm::dvec3 p = o + wall * d;
        return std::min(ball, std::max(std::abs(p.x), std::abs(p.y)) <= 3 ? wall : infinity);
    };
    for (std::size_t i = 0; i < views.size(); ++i)
        EXPECT_LT(share_off(downloaded(pass, int(i), views[i].camera), moved, views[i], 3e-3), 0.004) << i;
}

TEST_F(GlDepthPass, WhatNoViewSeesIsNotDrawn) {
    SceneModel model = ball_and_square();
    for (int i = 0; i < 20; ++i)
        add_ball(model, {10.0f * float(i - 10), 0, 40}, 0.5f, 20);
    gl::DepthPass pass(model);
    const std::span<const gl::DepthViewpoint> one(views.data(), 1);
    pass.draw(one);
    const std::uint64_t before = 2 * 60 * 2 * 60 + 2;
    EXPECT_GT(pass.triangle_count(), before);
    EXPECT_LE(pass.drawn().triangles, before);
    EXPECT_GT(pass.drawn().triangles, before / 3);
    EXPECT_LT(share_off(downloaded(pass, 0, views[0].camera), ball_and_square_m, views[0], 3e-3), 0.004);
}

/// Storage grows in steps of 64 with what is asked for and is kept; what an earlier draw left in it is not seen.
TEST_F(GlDepthPass, StorageGrowsAndIsKept) {
    gl::DepthPass pass(ball_and_square());
    pass.draw({views.data() + 2, 1});
    EXPECT_EQ(pass.size(), (gl::Size{192, 256}));
    pass.draw(views);
    const GLuint texture = pass.texture();
    const gl::DepthViewpoint away{{100, 90, 1}, {{0, 0, 5}, yaw_pitch(pi, 0)}};
    pass.draw({&away, 1});
    EXPECT_EQ(share_off(downloaded(pass, 0, away.camera), ball_and_square_m, away, 0), 0);
    pass.draw({views.data() + 1, 1});
    EXPECT_LT(share_off(downloaded(pass, 0, views[1].camera), ball_and_square_m, views[1], 3e-3), 0.004);
    EXPECT_EQ(pass.texture(), texture);
    EXPECT_EQ(pass.size(), (gl::Size{320, 256}));
}

/// Whoever drew before may have left any state; his clip control and depth function are his again.
TEST_F(GlDepthPass, StateOfOthersDoesNotMatter) {
    gl::DepthPass pass(ball_and_square());
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, 3, 3);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT_AND_BACK);
    glDepthMask(GL_FALSE);
    glDepthFunc(GL_NEVER);
    glClipControl(GL_UPPER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    pass.draw({views.data(), 1});
    GLint origin = 0, function = 0;
    glGetIntegerv(GL_CLIP_ORIGIN, &origin);
    glGetIntegerv(GL_DEPTH_FUNC, &function);
    EXPECT_EQ(GLenum(origin), GLenum(GL_UPPER_LEFT));
    EXPECT_EQ(GLenum(function), GLenum(GL_NEVER));
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDepthFunc(GL_LESS);
    EXPECT_LT(share_off(downloaded(pass, 0, views[0].camera), ball_and_square_m, views[0], 3e-3), 0.004);
}

/// Held to directions all around; with the starting vectors that iterations are caught by.
TEST(LengthGrowth, IsTheLongestThatAUnitVectorGets) {
    std::mt19937 random(5);
    std::normal_distribution<float> normal;
    std::vector<glm::mat4> transforms = {glm::mat4(1), glm::mat4(0), glm::mat4(glm::mat3(2, 0, 0, 0, 2, 0, 0, 0, 1)),
                                         glm::mat4(glm::mat3(1, -3, 0, -1, 3, 0, 0, 0, 1))};
    for (int i = 0; i < 60; ++i) {
        glm::mat4 transform(1);
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 3; ++row)
                transform[column][row] = normal(random);
        transforms.push_back(transform);
    }
    for (const glm::mat4& transform : transforms) {
        const glm::dmat3 m(transform);
        double longest = 0;
        for (int j = 1; j < 200; ++j)
            for (int i = 0; i < 400; ++i) {
                const double longitude = pi * i / 200, latitude = pi * j / 200;
                const glm::dvec3 unit(std::sin(latitude) * std::cos(longitude), std::cos(latitude),
                                      std::sin(latitude) * std::sin(longitude));
                longest = std::max(longest, glm::length(m * unit));
            }
        const double growth = double(gl::length_growth(transform));
        EXPECT_GE(growth, longest);
        EXPECT_LE(growth, 1.0005 * longest);
    }
}

/// The left half of a square's texture is cut away, repeated and mirrored.
TEST_F(GlDepthPass, MasksCutWhatTheyDoNotCover) {
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        SceneModel model;
        model.materials.resize(2);
        model.materials[1].alpha_mask = 0;
        model.alpha_masks.push_back({4, 3, wrap, wrap, {0, 0, 255, 255, 0, 0, 255, 255, 0, 0, 255, 0}});
        add_square(model, "opaque", 6, {0, 0, -5}, 0);
        add_square(model, "leaf", 1, {0, 0, -2}, 1);
        for (glm::vec2& uv : model.meshes[1].uvs)
            uv = 2.5f * uv - 0.6f;
        gl::DepthPass pass(model);
        const gl::DepthViewpoint view{{200, 200, pi / 2}, {}};
        pass.draw({&view, 1});
        const FloatImage depth_m = downloaded(pass, 0, view.camera);
        int off = 0;
        for (int y = 0; y < 200; ++y)
            for (int x = 0; x < 200; ++x) {
                const glm::dvec3 ray = view.camera.direction(x + 0.5, y + 0.5);
                const glm::dvec2 at = glm::dvec2(ray) * (2 / -ray.z);
                const glm::vec2 uv = 2.5f * glm::vec2(0.5 * (at.x + 1), 0.5 * (1 - at.y)) - 0.6f;
                const bool leaf = std::abs(at.x) <= 1 && std::abs(at.y) <= 1 && model.alpha_masks[0].covers(uv);
                const double expected = (leaf ? 2 : 5) / -ray.z;
                off += !(std::abs(double(depth_m.pixel(x, y)[0]) / expected - 1) < 1e-4);
            }
        // Pixels on the lines between texels.
        EXPECT_LT(off, 200) << int(wrap);
    }
}

}  // namespace
}  // namespace equistream::test
