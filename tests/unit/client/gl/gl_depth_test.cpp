#include "gl_fixture.h"
#include "gl_scene.h"

#include <client/depth/gl/depth_pass.h>
#include <client/depth/gl/gl_depth.h>
#include <client/depth/ray_depth.h>
#include <client/gpu/context.h>
#include <scenes/generate/generate.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/scenes/generate/scratch_folder.h>

#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

const EquirectCamera sphere{512, 256, {}};
const PerspectiveCamera eye{192, 108, pi / 2};

struct Agreement {
    int known = 0, off = 0;
};

/// Whether the depth around runs nearly straight: no outline is here, and nothing that is smaller than a sample, of
/// which texels beside the sample's own direction may show another.
bool is_smooth(const FloatImage& depth_m, int x, int y) {
    const auto at = [&](int column, int row) {
        return depth_m.pixel((column + depth_m.width()) % depth_m.width(), std::clamp(row, 0, depth_m.height() - 1))[0];
    };
    for (int j = -1; j <= 1; ++j)
        for (int i = -1; i <= 1; ++i) {
            const float middle = at(x + i, y + j);
            for (const float bend : {at(x + i - 1, y + j) - 2 * middle + at(x + i + 1, y + j),
                                     at(x + i, y + j - 1) - 2 * middle + at(x + i, y + j + 1)})
                if (!(std::abs(bend) <= 2e-3f * middle))
                    return false;
        }
    return true;
}

/// Of the samples that both know.
Agreement agreement(const FloatImage& expected, const FloatImage& found) {
    Agreement agreement;
    for (int y = 0; y < expected.height(); ++y)
        for (int x = 0; x < expected.width(); ++x) {
            const float a = expected.pixel(x, y)[0], b = found.pixel(x, y)[0];
            if (std::isnan(b) || !is_smooth(expected, x, y))
                continue;
            ++agreement.known;
            agreement.off += !(a == b || std::abs(a - b) <= 1e-3f * a);
        }
    return agreement;
}

int count_known(const FloatImage& depth_m) {
    return int(std::ranges::count_if(depth_m.samples(), [](float r) { return !std::isnan(r); }));
}

FloatImage cast(DepthSource& depth, const Camera& camera, const Pose& pose) {
    FloatImage depth_m(width_of(camera), height_of(camera), 1);
    depth.cast(camera, pose, depth_m.view());
    return depth_m;
}

/// The generated scene has leaves cut by masks, things that move, mirrors and thin rails.
class GlDepthOfPavilion : public testing::Test {
protected:
    static void SetUpTestSuite() {
        gl::abort_on_errors();
        folder = std::make_unique<ScratchFolder>("gl-depth");
        scene = load_scene(write_scene(make_scene(find_generator("pavilion")), folder->path()));
    }
    static void TearDownTestSuite() { folder.reset(); }

    static inline std::unique_ptr<ScratchFolder> folder;
    static inline SceneDescription scene;
};

TEST_F(GlDepthOfPavilion, IsThatOfRays) {
    RayDepth ray(scene);
    GlDepth drawn(scene), cube(scene, {.cube = true});
    EXPECT_FALSE(drawn.driver().empty());
    for (const double time_s : {0.0, 2.5}) {
        for (DepthSource* source :
             {static_cast<DepthSource*>(&ray), static_cast<DepthSource*>(&drawn), static_cast<DepthSource*>(&cube)})
            source->set_time(time_s);
        const Pose head = scene.camera_path.at(time_s);
        const Pose at{head.position_m + head.orientation * glm::dvec3(0.0315, 0, 0), head.orientation};
        const auto expect_rays = [&](const FloatImage& expected, const FloatImage& found) {
            const Agreement smooth = agreement(expected, found);
            EXPECT_GT(smooth.known, 0.15 * count_known(found)) << time_s;
            EXPECT_LT(smooth.off, 0.005 * smooth.known) << time_s;
        };
        const FloatImage flat_m = cast(drawn, eye, at);
        EXPECT_EQ(count_known(flat_m), eye.width * eye.height);
        expect_rays(cast(ray, eye, at), flat_m);
        const FloatImage expected_m = cast(ray, sphere, head), cube_m = cast(cube, sphere, head);
        EXPECT_EQ(count_known(cube_m), sphere.width * sphere.height);
        EXPECT_EQ(cube.figures().views, 6);
        expect_rays(expected_m, cube_m);
        const FloatImage part_m = cast(drawn, sphere, head);
        EXPECT_EQ(drawn.figures().views, 1);
        expect_rays(expected_m, part_m);
        // Of a whole sphere what an eye of 90 by 59 degrees sees, some 14 % in its middle, and what parallax adds.
        EXPECT_GT(count_known(part_m), 0.08 * sphere.width * sphere.height);
        EXPECT_LT(count_known(part_m), 0.3 * sphere.width * sphere.height);
        EXPECT_LT(drawn.figures().triangles, cube.figures().triangles);
    }
}

/// Where no eye has asked, all of a sphere is wanted.
TEST_F(GlDepthOfPavilion, WithoutEyesTheWholeSphereIsDrawn) {
    GlDepth drawn(scene);
    const FloatImage depth_m = cast(drawn, sphere, scene.camera_path.at(0));
    EXPECT_EQ(count_known(depth_m), sphere.width * sphere.height);
    EXPECT_EQ(drawn.figures().views, 6);
    drawn.set_time(1);
    cast(drawn, eye, scene.camera_path.at(1));
    EXPECT_LT(count_known(cast(drawn, sphere, scene.camera_path.at(1))), sphere.width * sphere.height / 2);
}

/// More views than are told apart: a sphere is drawn whole rather than without one of them.
TEST_F(GlDepthOfPavilion, ManyViewsGetTheWholeSphere) {
    GlDepth drawn(scene);
    const Pose head = scene.camera_path.at(0);
    for (int i = 0; i < 5; ++i)
        cast(drawn, eye, {head.position_m, head.orientation * yaw_pitch(0.01 * i, 0)});
    EXPECT_EQ(count_known(cast(drawn, sphere, head)), sphere.width * sphere.height);
}

/// Whoever else draws in this thread goes on with his own context.
TEST_F(GlDepthOfPavilion, LeavesTheCurrentContextAsItWas) {
    const auto other = gl::make_offscreen_context();
    GLuint texture = 0;
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    const auto expect_other = [texture] { EXPECT_EQ(glIsTexture(texture), GL_TRUE); };
    {
        GlDepth drawn(scene);
        expect_other();
        cast(drawn, eye, scene.camera_path.at(0));
        expect_other();
        EXPECT_FALSE(drawn.driver().empty());
        expect_other();
    }
    expect_other();
    glDeleteTextures(1, &texture);
}

}  // namespace

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
