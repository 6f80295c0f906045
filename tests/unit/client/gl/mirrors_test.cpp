/// Mirrors and glass on the GPU are what rework_specular makes of them.
#include "filled_pictures.h"
#include "found_pictures.h"
#include "gl_fixture.h"

#include <client/reflections/gl/specular.h>
#include <tests/unit/client/mirror_room.h>

#include <client/reflections/specular.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream::test {
namespace {

class GlMirrors : public Gl {
protected:
    /// Both eyes' pictures after the GPU has been over `before`.
    std::array<EyePicture, 2> rework(const SourceView& source, std::span<const EyeView> eyes, const EyePicture& before,
                                     MirrorTreatment treatment) {
        gl::SourceTextures textures;
        textures.upload(source);
        specular.upload(source);
        gl::EyeTargets targets;
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
