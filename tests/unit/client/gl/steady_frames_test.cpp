/// Frame after frame of one size, nothing is made on the GPU but what the first one made.
#include "filled_pictures.h"
#include "gl_fixture.h"
#include "made_objects.h"

#include <client/confidence/gl/reliability_map.h>
#include <client/fill/gl/gap_resample.h>
#include <client/fill/gl/push_pull.h>
#include <client/warp/gl/resample.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/fill_scene.h>

#include <array>

namespace equistream::test {
namespace {

using GlSteadyFrames = Gl;

TEST_F(GlSteadyFrames, MakeNothing) {
    FillScene scene;
    const Rendered rendered = render(wall_alone, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, scene.right);
    const SourceView small = rendered.source(0.063);
    Patches made;
    made.render_from(scene.left);
    const PatchesView patches = made.view(scene.left);
    gl::SourceTextures main_textures, small_textures;
    gl::PatchTextures patch_textures;
    gl::TargetsWithDepth targets;
    gl::GapTiles gaps;
    gl::Resample engine(gl::ResampleRule::seen, default_error_budget_px);
    gl::GapResample resample;
    gl::PatchResample patch_resample;
    gl::PushPull push_pull;
    gl::ReliabilityMap map;
    gl::SpecularTextures specular;
    std::mt19937 random(3);
    const auto frame = [&](const Pose& pose) {
        main_textures.upload(scene.main_view);
        small_textures.upload(small);
        patch_textures.upload(patches);
        specular.upload(scene.main_view);
        targets.size_for(scene.camera, 2);
        const std::array eyes = {scene.eye, EyeView{scene.camera, pose, scene.eye.depth_m}};
        for (int k = 0; k < 2; ++k)
            targets.upload_depth(k, scene.camera, scene.eye.depth_m);
        const gl::EyeDepth depth = targets.depth();
        engine.reproject(scene.main_view, main_textures, eyes, depth, targets);
        upload(RandomPicture(scene.camera.width, scene.camera.height, random).picture, 1, targets);
        gaps.find(targets);
        const gl::GapTargets to{eyes, depth, gaps, targets};
        patch_resample.fill(patches, patch_textures, to);
        resample.fill({small, small_textures, PixelOrigin::small}, to);
        push_pull.fill(scene.main_view, eyes, depth, gaps, targets);
        map.estimate({scene.main_view, main_textures, specular}, {eyes, depth, targets});
        EyePicture picture;
        targets.download(1, picture);
        return picture.count(PixelOrigin::gap);
    };
    frame(scene.right);
    GLuint framebuffer = 0;
    glCreateFramebuffers(1, &framebuffer);
    const gl::Framebuffer owner(framebuffer);
    const MadeObjects made_since;
    for (const double y : {0.01, -0.02, 0.03})
        EXPECT_EQ(frame({{0.02, y, 0}, yaw_pitch(y, 0)}), 0) << "no gap stays open";
    EXPECT_EQ(made_since.count(), 0);
    const gl::GapResample another;
    EXPECT_GE(made_since.count(), 3) << "programs, shaders and buffers count";
}

}  // namespace
}  // namespace equistream::test
