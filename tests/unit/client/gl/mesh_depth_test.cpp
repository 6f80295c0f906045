/// Engine `mesh` on the GPU shows what it shows on the CPU.
#include "filled_pictures.h"
#include "gl_fixture.h"
#include "made_objects.h"

#include <client/warp/gl/mesh_depth.h>
#include <client/warp/gl/resample.h>
#include <tests/unit/client/engine_scenes.h>

#include <client/warp/engine.h>
#include <equistream/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{240, 150, pi / 2};
// The budget of everything else, which is tighter than the mesh's own: less is left to rounding at edges.
const EngineOptions strict{.source_depth_budget_px = default_error_budget_px};

class GlMeshDepth : public Gl {
protected:
    using Seen = std::array<EyePicture, 2>;

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
        for (std::size_t i = 0; i < eyes.size(); ++i)
            targets.download(int(i), seen[i]);
        return seen;
    }

    /// Blocks whose cells or whose points were built.
    std::int64_t built(const SourceView& view, const gl::SourceTextures& textures, std::span<const EyeView> eyes) {
        const IndirectGroups groups;
        mesh.find(view, textures, eyes);
        return groups.count();
    }

    static void expect_the_cpus(const Engine& cpu, const EyeView& eye, const EyePicture& found) {
        EyePicture expected;
        cpu.reproject(eye, expected);
        EXPECT_GT(psnr_where_seen(expected, found), 50);
        // Of 36,000 pixels: those on edges, where rounding decides.
        EXPECT_LE(other_origins(expected, found), 36);
    }

    /// 1 / planar depth.
    static FloatImage found_by(gl::MeshDepth& by, const SourceView& view, const gl::SourceTextures& textures,
                               const EyeView& eye) {
        by.find(view, textures, std::span(&eye, 1));
        glFinish();
        FloatImage found(eye.camera.width, eye.camera.height, 1);
        gl::download(by.depth().texture, 0, {eye.camera.width, eye.camera.height}, {GL_RED, GL_FLOAT, sizeof(float)},
                     found.samples().data(), sizeof(float) * std::size_t(eye.camera.width));
        return found;
    }

    static int differing(const FloatImage& a, const FloatImage& b) {
        int count = 0;
        for (std::size_t i = 0; i < a.samples().size(); ++i)
            count += !(std::abs(a.samples()[i] - b.samples()[i]) < 1e-5f) &&
                     !(std::isnan(a.samples()[i]) && std::isnan(b.samples()[i]));
        return count;
    }

    gl::MeshDepth mesh{strict};
    gl::Resample surface{gl::ResampleRule::seen, mesh.traits().error_budget_px};
};

/// A plain sphere of so many columns takes little room, whatever a driver's limit is.
TEST_F(GlMeshDepth, TakesSpheresAsWideAsTheBoundAsksFor) {
    constexpr int columns = 6032;
    constexpr float radius_m = 3;
    FloatImage depth_m(columns, columns / 2, 1);
    std::ranges::fill(depth_m.samples(), radius_m);
    const ByteImage colour(columns, columns / 2, 3);
    SourceView view;
    view.rgb = colour.view();
    view.camera = EquirectCamera{columns, columns / 2, {}};
    view.depth_m = depth_m.view();
    view.box_radius_m = 0.0315;
    gl::SourceTextures textures;
    textures.upload(view);
    const EyeView eye{eye_camera, Pose{{0.0315, 0, 0}, yaw_pitch(0, 0)}};
    const FloatImage found = found_by(mesh, view, textures, eye);
    for (const auto& [x, y] : {std::pair{0, 0}, {120, 75}, {239, 149}}) {
        const glm::dvec3 ray = eye_camera.direction(x + 0.5, y + 0.5);
        // On |b + t d| = R, at planar depth -t d.z.
        const double along = glm::dot(eye.pose.position_m, ray);
        const double t = -along + std::sqrt(along * along - glm::dot(eye.pose.position_m, eye.pose.position_m) +
                                            radius_m * radius_m);
        EXPECT_NEAR(found.samples()[std::size_t(y) * 240 + std::size_t(x)], 1 / (-t * ray.z), 2e-4);
    }
}

/// What failed is not taken for done.
TEST_F(GlMeshDepth, RefusesWhatIsTooLargeEachTime) {
    SourceView view;
    view.camera = PerspectiveCamera{gl::MeshDepth::max_side + 1, 1, pi / 2};
    gl::SourceTextures textures;
    const EyeView eye{eye_camera, Pose{}};
    for (int i = 0; i < 2; ++i)
        EXPECT_THROW(mesh.find(view, textures, std::span(&eye, 1)), WorkError);
}

TEST_F(GlMeshDepth, ShowsWhatTheCpuShows) {
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto cpu = make_engine("mesh", strict);
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
                expect_the_cpus(*cpu, eyes[k], seen[k]);
            }
        }
    }
}

/// A mesh of which parts were built for other eyes shows these what they see; what is there is not built again.
TEST_F(GlMeshDepth, KeepsWhatEyesInTheBoxSee) {
    const auto cpu = make_engine("mesh", strict);
    for (const Camera& camera : engine_sources(360)) {
        SCOPED_TRACE(width_of(camera));
        const Pose centre{{0, 0, 0}, yaw_pitch(0.7, 0.1)};
        const Rendered source = render(furnished(), smooth_colour, camera, centre);
        const SourceView view = source.source(0.11);
        cpu->set_source(view);
        gl::SourceTextures textures;
        textures.upload(view);
        for (const double yaw : {0.7, 1.3, -0.2, 0.7}) {
            SCOPED_TRACE(yaw);
            const std::array eyes = {EyeView{eye_camera, {{-0.09, 0.02, 0.03}, yaw_pitch(yaw, 0.2)}, {}},
                                     EyeView{eye_camera, {{0.05, -0.04, 0.06}, yaw_pitch(yaw, -0.3)}, {}}};
            built(view, textures, eyes);
            EXPECT_EQ(built(view, textures, eyes), 0);
            const Seen seen = see(view, textures, eyes);
            expect_the_cpus(*cpu, eyes[0], seen[0]);
            expect_the_cpus(*cpu, eyes[1], seen[1]);
        }
    }
}

/// Once round, a block's cells and its points are built once each, and never again.
TEST_F(GlMeshDepth, BuildsWhatComesIntoView) {
    const Rendered source = render(furnished(), smooth_colour, EquirectCamera{512, 256, {}}, Pose{});
    const SourceView view = source.source(0.1);
    gl::SourceTextures textures;
    textures.upload(view);
    constexpr std::int64_t all = 2 * 16 * 9;
    std::int64_t round = 0;
    for (int turn = 0; turn < 2; ++turn)
        for (int yaw = 0; yaw < 8; ++yaw) {
            std::int64_t here = 0;
            for (const double pitch : {0.0, 1.2, -1.2}) {
                const EyeView eye{{60, 60, 1.4}, {{0.05, 0, 0}, yaw_pitch(2 * pi * yaw / 8, pitch)}, {}};
                here += built(view, textures, std::span(&eye, 1));
            }
            EXPECT_TRUE(turn == 0 ? here < all : here == 0) << turn << ' ' << yaw << ' ' << here;
            round += here;
        }
    EXPECT_EQ(round, all);
}

/// A walk from the box to twice as far away and back, and zooming to half the angle.
TEST_F(GlMeshDepth, IsBuiltAnewInSteps) {
    const Rendered source = render(furnished(), smooth_colour, EquirectCamera{128, 64, {}}, Pose{});
    const SourceView view = source.source(0.1);
    gl::SourceTextures textures;
    textures.upload(view);
    int builds = 0;
    const auto refresh = [&](double x_m, double focal) {
        const EyeView eye{{64, 40, 2 * std::atan(32 / focal)}, {{x_m, 0, 0}, {1, 0, 0, 0}}, {}};
        const std::int64_t blocks = built(view, textures, std::span(&eye, 1));
        builds += blocks > 0;
        return blocks;
    };
    EXPECT_GT(refresh(0.05, 32), 0);
    EXPECT_EQ(refresh(0.099, 32), 0);
    builds = 0;
    for (int step = 0; step <= 100; ++step)
        refresh(0.1 + 0.001 * step, 32);
    for (int step = 100; step >= 0; --step)
        refresh(0.1 + 0.001 * step, 32);
    for (int step = 0; step <= 100; ++step)
        refresh(0.1, 32 + 0.32 * step);
    EXPECT_GE(builds, 6) << "what cells may be off by became another";
    EXPECT_LE(builds, 20);
}

/// A box comes, goes to and fro, and leaves: what is built is what it left and reached, and all is as if built anew.
TEST_F(GlMeshDepth, BuildsAnewWhatHasChanged) {
    const Rendered source = render(furnished(), smooth_colour, EquirectCamera{720, 360, {}}, Pose{});
    const EyeView eye{eye_camera, {{0.04, 0.02, 0}, {1, 0, 0, 0}}, {}};
    const auto eyes = std::span(&eye, 1);
    FloatImage depth_m = source.depth_m;
    gl::SourceTextures textures;
    const auto show_box_at = [&](int left) {
        depth_m = source.depth_m;
        for (int y = 150; y < 190 && left > 0; ++y)
            for (int x = left; x < left + 40; ++x)
                *depth_m.pixel(x, y) = 0.8f + 0.002f * float(x - left + y);
        SourceView view = source.source(0.1);
        view.depth_m = depth_m.view();
        textures.upload(view);
        mesh.forget_source();
        const std::int64_t blocks = built(view, textures, eyes);
        gl::MeshDepth another{strict};
        EXPECT_EQ(differing(found_by(mesh, view, textures, eye), found_by(another, view, textures, eye)), 0) << left;
        return blocks;
    };
    const std::int64_t all = show_box_at(0);
    EXPECT_GT(all, 60);
    for (const int left : {340, 350, 335, 370, 0, 340}) {
        const std::int64_t some = show_box_at(left);
        EXPECT_GT(some, 4) << left;
        EXPECT_LT(some, 0.5 * double(all)) << left;
    }
    EXPECT_EQ(show_box_at(340), 0) << "nothing has changed";
}

/// Every other refresh is drawn under a condition that is not met, so the GPU skips it.
TEST_F(GlMeshDepth, IsWholeAfterARefreshThatWasSkipped) {
    const Rendered source = render(furnished(), smooth_colour, EquirectCamera{360, 180, {}}, Pose{});
    const SourceView view = source.source(0.1);
    gl::SourceTextures textures;
    textures.upload(view);
    GLuint never = 0;
    glCreateQueries(GL_ANY_SAMPLES_PASSED, 1, &never);
    glBeginQuery(GL_ANY_SAMPLES_PASSED, never);
    glEndQuery(GL_ANY_SAMPLES_PASSED);
    gl::MeshDepth drawn{strict};
    for (int i = 0; i < 40; ++i) {
        SCOPED_TRACE(i);
        // In a box that is wide, then narrow: all is built anew.
        const EyeView eye{eye_camera, {{i % 2 == 0 ? 0.3 : 0.05, 0.02, 0}, {1, 0, 0, 0}}, {}};
        glBeginConditionalRender(never, GL_QUERY_WAIT);
        mesh.find(view, textures, std::span(&eye, 1));
        glEndConditionalRender();
        mesh.forget_source();
        drawn.find(view, textures, std::span(&eye, 1));
        EXPECT_EQ(differing(found_by(mesh, view, textures, eye), found_by(drawn, view, textures, eye)), 0);
    }
    glDeleteQueries(1, &never);
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
        by.forget_source();
        return found_by(by, view_of(depth_m), textures, eye);
    };
    gl::MeshDepth another{strict};
    const FloatImage expected = seen_by(another, ragged);
    const auto pixels = double(expected.samples().size());
    EXPECT_GT(double(std::ranges::count_if(expected.samples(), [](float z) { return z > 0; })), 0.8 * pixels);
    seen_by(mesh, even);
    seen_by(mesh, ragged);
    EXPECT_EQ(differing(seen_by(mesh, ragged), expected), 0) << "from the second refresh on";
    EXPECT_GT(differing(seen_by(mesh, even), expected), 0.9 * pixels);
    EXPECT_EQ(differing(seen_by(mesh, ragged), expected), 0) << "there is room now";
}

}  // namespace
}  // namespace equistream::test
