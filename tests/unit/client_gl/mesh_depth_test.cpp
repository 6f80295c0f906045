/// Engine `mesh` on the GPU shows what it shows on the CPU.
#include "engine_scenes.h"
#include "found_pictures.h"
#include "gl_fixture.h"
#include "recorded_calls.h"

#include <reproject/gl/look_up.h>
#include <reproject/gl/mesh_depth.h>

#include <equistream_client/engine.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{240, 150, pi / 2};

class GlMeshDepth : public Gl {
protected:
    struct Seen {
        std::array<EyePicture, 2> pictures;
        std::array<FloatImage, 2> inverse_planar;
    };

    Seen see(const SourceView& view, std::span<const EyeView> eyes) {
        gl::SourceTextures textures;
        textures.upload(view);
        mesh.forget_source();
        return see(view, textures, eyes);
    }

    Seen see(const SourceView& view, const gl::SourceTextures& textures, std::span<const EyeView> eyes) {
        gl::EyeTargets targets;
        targets.size_for(eyes.front().camera, int(eyes.size()));
        mesh.find(view, textures, eyes);
        surface.reproject(view, textures, eyes, mesh.depth(), targets);
        mesh.forget_gaps(targets);
        Seen seen;
        for (std::size_t i = 0; i < eyes.size(); ++i) {
            targets.download(int(i), seen.pictures[i]);
            seen.inverse_planar[i] = FloatImage(eye_camera.width, eye_camera.height, 1);
            gl::download(mesh.depth().texture, int(i), targets.size(), {GL_RED, GL_FLOAT, sizeof(float)},
                         seen.inverse_planar[i].samples().data(), sizeof(float) * std::size_t(eye_camera.width));
        }
        return seen;
    }

    static constexpr std::ptrdiff_t kept = 1, built = 3;
    std::ptrdiff_t dispatches(const SourceView& view, const gl::SourceTextures& textures,
                              std::span<const EyeView> eyes) {
        const RecordedCalls calls;
        mesh.find(view, textures, eyes);
        return calls.dispatches();
    }

    static void expect_the_cpus(const Engine& cpu, const EyeView& eye, const EyePicture& found) {
        EyePicture expected;
        cpu.reproject(eye, expected);
        EXPECT_GT(psnr_where_seen(expected, found), 50);
        // Of 36,000 pixels: those on edges, where rounding decides.
        EXPECT_LE(other_origins(expected, found), 36);
    }

    gl::MeshDepth mesh;
    gl::LookUp surface{true};
};

TEST_F(GlMeshDepth, ShowsWhatTheCpuShows) {
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto cpu = make_engine("mesh");
    for (const Camera& camera : engine_sources(720)) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        const SourceView view = source.source(0.11);
        cpu->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            const std::array<EyeView, 2> eyes = {EyeView{eye_camera, poses[i], {}}, {eye_camera, poses[i + 1], {}}};
            const Seen seen = see(view, eyes);
            for (std::size_t k = 0; k < 2; ++k) {
                SCOPED_TRACE(i + k);
                expect_the_cpus(*cpu, eyes[k], seen.pictures[k]);
            }
        }
    }
}

/// A mesh that was built for other eyes shows these what they see.
TEST_F(GlMeshDepth, KeepsWhatEyesInTheBoxSee) {
    const auto cpu = make_engine("mesh");
    for (const Camera& camera : engine_sources(360)) {
        SCOPED_TRACE(width_of(camera));
        const Pose centre{{0, 0, 0}, yaw_pitch(0.7, 0.1)};
        const Rendered source = render(furnished(), smooth_colour, camera, centre);
        const SourceView view = source.source(0.11);
        cpu->set_source(view);
        gl::SourceTextures textures;
        textures.upload(view);
        const std::array<double, 3> yaws = {0.7, 1.3, -0.2};
        for (std::size_t i = 0; i < yaws.size(); ++i) {
            SCOPED_TRACE(yaws[i]);
            const std::array eyes = {EyeView{eye_camera, {{-0.09, 0.02, 0.03}, yaw_pitch(yaws[i], 0.2)}, {}},
                                     EyeView{eye_camera, {{0.05, -0.04, 0.06}, yaw_pitch(yaws[i], -0.3)}, {}}};
            const std::ptrdiff_t dispatched = dispatches(view, textures, eyes);
            EXPECT_TRUE(i == 0 ? dispatched >= built : dispatched == kept) << dispatched;
            const Seen seen = see(view, textures, eyes);
            expect_the_cpus(*cpu, eyes[0], seen.pictures[0]);
            expect_the_cpus(*cpu, eyes[1], seen.pictures[1]);
        }
    }
}

/// A walk from the box to twice as far away and back, and zooming to half the angle.
TEST_F(GlMeshDepth, IsBuiltAnewInSteps) {
    const Rendered source = render(furnished(), smooth_colour, EquirectCamera{128, 64, {}}, Pose{});
    const SourceView view = source.source(0.1);
    gl::SourceTextures textures;
    textures.upload(view);
    const auto refresh = [&](double x_m, double focal) {
        const EyeView eye{{64, 40, 2 * std::atan(32 / focal)}, {{x_m, 0, 0}, {1, 0, 0, 0}}, {}};
        return dispatches(view, textures, std::span(&eye, 1));
    };
    EXPECT_GE(refresh(0.05, 32), built);
    EXPECT_EQ(refresh(0.099, 32), kept);
    std::ptrdiff_t all = 0;
    for (int step = 0; step <= 100; ++step)
        all += refresh(0.1 + 0.001 * step, 32);
    for (int step = 100; step >= 0; --step)
        all += refresh(0.1 + 0.001 * step, 32);
    for (int step = 0; step <= 100; ++step)
        all += refresh(0.1, 32 + 0.32 * step);
    const std::ptrdiff_t builds = (all - 303 * kept) / (built - kept);
    EXPECT_GE(builds, 6) << "what cells may be off by became another";
    EXPECT_LE(builds, 20);
}

/// Frames that are easily told follow frames that are not, and the other way round.
TEST_F(GlMeshDepth, MakesRoomForWhatASourceNeeds) {
    const EquirectCamera camera{128, 64, {}};
    FloatImage even(camera.width, camera.height, 1), ragged(camera.width, camera.height, 1);
    std::mt19937 random(5);
    for (float& r : even.samples())
        r = 3;
    for (float& r : ragged.samples())
        r = std::uniform_real_distribution<float>(1, 9)(random);
    const ByteImage rgb(camera.width, camera.height, 3);
    const auto view_of = [&](const FloatImage& depth_m) {
        return SourceView{.rgb = rgb.view(), .camera = camera, .depth_m = depth_m.view(), .box_radius_m = 0.1};
    };
    const EyeView eye{eye_camera, {{0.02, 0.01, 0}, {1, 0, 0, 0}}, {}};
    const auto seen_by = [&](gl::MeshDepth& by, const FloatImage& depth_m) {
        gl::SourceTextures textures;
        textures.upload(view_of(depth_m));
        by.find(view_of(depth_m), textures, std::span(&eye, 1));
        glFinish();
        std::vector<float> seen(std::size_t(eye_camera.width) * std::size_t(eye_camera.height));
        gl::download(by.depth().texture, 0, {eye_camera.width, eye_camera.height}, {GL_RED, GL_FLOAT, sizeof(float)},
                     seen.data(), sizeof(float) * std::size_t(eye_camera.width));
        return seen;
    };
    const auto differing = [](const std::vector<float>& a, const std::vector<float>& b) {
        int count = 0;
        for (std::size_t i = 0; i < a.size(); ++i)
            count += !(std::abs(a[i] - b[i]) < 1e-5f) && !(std::isnan(a[i]) && std::isnan(b[i]));
        return count;
    };
    gl::MeshDepth another;
    const std::vector<float> expected = seen_by(another, ragged);
    EXPECT_GT(std::ranges::count_if(expected, [](float z) { return z > 0; }), 0.8 * double(expected.size()));
    seen_by(mesh, even);
    mesh.forget_source();
    seen_by(mesh, ragged);
    EXPECT_EQ(differing(seen_by(mesh, ragged), expected), 0) << "from the second refresh on";
    mesh.forget_source();
    EXPECT_EQ(differing(seen_by(mesh, even), std::vector<float>(expected.size())), int(expected.size()));
    mesh.forget_source();
    EXPECT_EQ(differing(seen_by(mesh, ragged), expected), 0) << "there is room now";
}

}  // namespace
}  // namespace equistream::test
