/// Engines on the GPU that find the eyes' depth, but for `mesh`, show what their plain references show.
#include "filled_pictures.h"
#include "gl_fixture.h"

#include <client/reflections/gl/specular.h>
#include <client/reflections/specular.h>
#include <client/warp/engine.h>
#include <client/warp/gl/eye_depth_finder.h>
#include <client/warp/gl/resample.h>
#include <tests/support/references/plain_engines.h>
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/engine_scenes.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{120, 75, pi / 2};
constexpr int source_width = 360;

/// Within which an engine is its plain reference, of 9,000 pixels.
struct Expected {
    const char* engine;
    double min_psnr_db;
    int max_others;

    friend std::ostream& operator<<(std::ostream& out, const Expected& expected) { return out << expected.engine; }
};

class GlFindingEngines : public Gl, public testing::WithParamInterface<Expected> {};

INSTANTIATE_TEST_SUITE_P(Client, GlFindingEngines,
                         testing::Values(Expected{"mesh-plain", 50, 1}, Expected{"lean", 50, 8}), [](const auto& test) {
                             std::string name = test.param.engine;
                             std::erase(name, '-');
                             return name;
                         });

std::array<EyePicture, 2> seen_by(gl::EyeDepthFinder& finder, const SourceView& view, std::span<const EyeView> eyes) {
    gl::SourceTextures textures;
    textures.upload(view);
    gl::EyeTargets targets;
    targets.size_for(eyes.front().camera, int(eyes.size()));
    gl::Resample surface{finder.traits().only_seen ? gl::ResampleRule::seen : gl::ResampleRule::any,
                         finder.traits().error_budget_px};
    finder.forget_source();
    finder.find(view, textures, eyes);
    surface.reproject(view, textures, eyes, finder.depth(), targets);
    std::array<EyePicture, 2> pictures;
    for (std::size_t i = 0; i < eyes.size(); ++i)
        targets.download(int(i), pictures[i]);
    return pictures;
}

TEST_P(GlFindingEngines, ShowWhatTheirReferencesShow) {
    const auto [engine, min_psnr_db, max_others] = GetParam();
    const auto finder = gl::make_eye_depth_from_source(engine);
    const SurfaceScene scene = furnished();
    const std::vector<Pose> poses = engine_eyes();
    const auto plain = plain::make_engine(engine);
    for (const Camera& camera : engine_sources(source_width)) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        const SourceView view = source.source(0.11);
        plain->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            const std::array<EyeView, 2> eyes = {EyeView{eye_camera, poses[i], {}}, {eye_camera, poses[i + 1], {}}};
            const std::array<EyePicture, 2> seen = seen_by(*finder, view, eyes);
            for (std::size_t k = 0; k < 2; ++k) {
                EyePicture expected;
                plain->reproject(eyes[k], expected);
                EXPECT_GT(psnr_where_seen(expected, seen[k]), min_psnr_db) << "eye " << i + k;
                EXPECT_LE(other_origins(expected, seen[k]), max_others) << "eye " << i + k;
            }
        }
    }
}

/// The CPU's own engine, where samples are few or unknown.
void expect_the_cpus(const std::string& engine, gl::EyeDepthFinder& finder, const SourceView& view,
                     const EyeView& eye) {
    const auto cpu = make_engine(engine);
    cpu->set_source(view);
    EyePicture expected;
    cpu->reproject(eye, expected);
    const EyePicture found = seen_by(finder, view, {&eye, 1})[0];
    EXPECT_GT(psnr_where_seen(expected, found), 50);
    EXPECT_LE(other_origins(expected, found), eye.camera.width * eye.camera.height / 250 + 1);
}

/// Patches of which nothing is known, small ones and large, over edges, sky and seam too.
TEST_P(GlFindingEngines, ShowNothingWhereNothingIsKnown) {
    const auto finder = gl::make_eye_depth_from_source(GetParam().engine);
    std::mt19937 random(3);
    for (const Camera& camera : engine_sources(240)) {
        SCOPED_TRACE(width_of(camera));
        Rendered source = render(furnished(), smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        FloatImage& depth_m = source.depth_m;
        for (int patch = 0; patch < 40; ++patch) {
            const int left = int(random() % unsigned(depth_m.width())),
                      top = int(random() % unsigned(depth_m.height()));
            const int side = 1 << random() % 5;
            for (int y = top; y < std::min(top + side, depth_m.height()); ++y)
                for (int x = left; x < left + side; ++x)
                    *depth_m.pixel(x % depth_m.width(), y) = std::nanf("");
        }
        const SourceView view = source.source(0.11);
        for (const double yaw : {0.5, 2.5})
            expect_the_cpus(GetParam().engine, *finder, view,
                            {{120, 75, pi / 2}, {{-0.063, 0.03, 0}, yaw_pitch(yaw, 0.1)}, {}});
    }
}

/// Of no whole number of blocks, tiles or work groups; one eye.
TEST_P(GlFindingEngines, ShowSourcesAndEyesOfAnySize) {
    const auto finder = gl::make_eye_depth_from_source(GetParam().engine);
    for (const Camera& camera :
         std::vector<Camera>{EquirectCamera{46, 23, {}}, EquirectCamera{45, 22, {}}, PerspectiveCamera{33, 31, 1.8},
                             PerspectiveCamera{5, 3, 1.8}, EquirectCamera{98, 31, {-2.4, 2.1, -0.8, 1.1}}}) {
        SCOPED_TRACE(width_of(camera));
        const Rendered source = render(hall, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        for (const auto& [width, height] : {std::pair{37, 21}, {1, 1}, {64, 33}})
            for (const double pitch : {0.1, 1.4, -1.5})
                expect_the_cpus(GetParam().engine, *finder, source.source(0.11),
                                {{width, height, 1.5}, {{0.05, 0.02, -0.06}, yaw_pitch(0.7, pitch)}, {}});
    }
}

/// A picture of the same camera after another.
TEST_P(GlFindingEngines, KeepNothingOfTheSourceBefore) {
    const auto finder = gl::make_eye_depth_from_source(GetParam().engine),
               another = gl::make_eye_depth_from_source(GetParam().engine);
    const EquirectCamera camera{240, 120, {}};
    const Rendered near = render(hall, smooth_colour, camera, {}), far = render(furnished(), smooth_colour, camera, {});
    const std::array<EyeView, 2> eyes = {EyeView{eye_camera, {{0.05, 0, 0}, yaw_pitch(0.2, 0)}, {}},
                                         EyeView{eye_camera, {{-0.05, 0, 0}, yaw_pitch(0.2, 0)}, {}}};
    seen_by(*finder, near.source(0.11), eyes);
    const auto found = seen_by(*finder, far.source(0.11), eyes), expected = seen_by(*another, far.source(0.11), eyes);
    for (std::size_t k = 0; k < 2; ++k) {
        EXPECT_TRUE(std::ranges::equal(found[k].rgba.samples(), expected[k].rgba.samples()));
        EXPECT_GT(found[k].count(PixelOrigin::source), eye_camera.width * eye_camera.height * 5 / 6);
    }
}

}  // namespace

// Mirrors and glass on the GPU are what rework_specular makes of them.

namespace {

class GlMirrors : public Gl {
protected:
    /// Both eyes' pictures after the GPU has been over `before`.
    std::array<EyePicture, 2> rework(const SourceView& source, std::span<const EyeView> eyes, const EyePicture& before,
                                     MirrorTreatment treatment) {
        gl::SourceTextures textures;
        textures.upload(source);
        specular.upload(source);
        gl::TargetsWithDepth targets;
        targets.size_for(eyes[0].camera, 2);
        for (int i = 0; i < 2; ++i) {
            upload(before, i, targets);
            targets.upload_depth(i, eyes[std::size_t(i)].camera, eyes[std::size_t(i)].depth_m);
        }
        mirrors.rework({source, textures, specular}, eyes, targets.depth(), targets, treatment);
        std::array<EyePicture, 2> pictures;
        for (int i = 0; i < 2; ++i)
            targets.download(i, pictures[std::size_t(i)]);
        return pictures;
    }

    gl::SpecularTextures specular;
    gl::Mirrors mirrors;
};

TEST_F(GlMirrors, AreWhatTheCpuMakesOfThem) {
    const PerspectiveCamera camera{200, 150, pi / 2};
    const std::array<Pose, 2> poses = {Pose{{0.1, 0.08, 0.02}, yaw_pitch(0.05, -0.5)},
                                       Pose{{-0.05, 0.02, 0.08}, yaw_pitch(-0.1, -0.7)}};
    for (const Camera& from : {Camera(EquirectCamera{1024, 512, {}}), Camera(PerspectiveCamera{800, 600, 1.9})}) {
        const bool is_flat = std::holds_alternative<PerspectiveCamera>(from);
        MirrorView main(from, {{0, 0, 0}, is_flat ? yaw_pitch(0, -0.6) : glm::dquat(1, 0, 0, 0)});
        // A curved mirror's images in one half.
        for (int y = 0; y < main.image_m.height(); ++y)
            for (int x = 0; x < main.image_m.width() / 2; ++x)
                *main.image_m.pixel(x, y) *= float(1 + 0.1 * std::sin(0.04 * x));
        const SourceView source = main.source();
        const std::array<MirrorView, 2> truths = {MirrorView(camera, poses[0]), MirrorView(camera, poses[1])};
        const std::array<EyeView, 2> eyes = {EyeView{camera, poses[0], truths[0].picture.depth_m.view()},
                                             EyeView{camera, poses[1], truths[1].picture.depth_m.view()}};
        EyePicture before;
        before.reset(camera);
        std::ranges::fill(before.origin.samples(), std::uint8_t(PixelOrigin::source));
        for (const MirrorTreatment treatment : {MirrorTreatment::images, MirrorTreatment::gaps}) {
            const auto found = rework(source, eyes, before, treatment);
            for (std::size_t i = 0; i < 2; ++i) {
                SCOPED_TRACE(std::to_string(i) + (is_flat ? " flat " : " sphere ") +
                             std::string(mirror_treatment_names()[std::size_t(treatment)]));
                EyePicture expected = before;
                const SpecularCounts counts = rework_specular(source, eyes[i], expected, {.treatment = treatment});
                EXPECT_GT(treatment == MirrorTreatment::images ? counts.by_image : counts.gaps, 1000);
                EXPECT_GT(psnr_where_seen(expected, found[i]), 50);
                EXPECT_LE(other_origins(expected, found[i]), counts.all() / 500);
            }
        }
    }
}

/// An eye at the source's own place sees in mirrors what the source saw.
TEST_F(GlMirrors, FromTheSourcesOwnPlaceStay) {
    const PerspectiveCamera camera{200, 150, pi / 2};
    const Pose down{{0, 0, 0}, yaw_pitch(0, -0.6)};
    const MirrorView main(EquirectCamera{512, 256, {}}, {{0, 0, 0}, {1, 0, 0, 0}}), truth(camera, down);
    const EyeView eye{camera, down, truth.picture.depth_m.view()};
    EyePicture before;
    before.reset(camera);
    std::ranges::fill(before.origin.samples(), std::uint8_t(PixelOrigin::source));
    const auto found = rework(main.source(), std::array{eye, eye}, before, MirrorTreatment::gaps);
    EXPECT_EQ(other_origins(before, found[0]), 0);
}

}  // namespace
}  // namespace equistream::test
