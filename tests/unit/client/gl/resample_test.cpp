#include "filled_pictures.h"
#include "gl_fixture.h"

#include <client/warp/gl/resample.h>
#include <tests/unit/client/engine_scenes.h>

#include <client/warp/engine.h>

#include <tests/support/references/plain_engines.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <random>

namespace equistream::test {
namespace {

const PerspectiveCamera eye_camera{240, 150, pi / 2};

class GlResample : public Gl {
protected:
    /// Both engines' pictures of two eyes at once are those of the plain implementation.
    void expect_reference(bool surface, const SourceView& view, const Distance& distance, std::span<const Pose> poses) {
        gl::SourceTextures textures;
        textures.upload(view);
        gl::Resample resample(surface ? gl::ResampleRule::seen : gl::ResampleRule::direction, default_error_budget_px);
        gl::TargetsWithDepth targets;
        const auto reference = plain::make_engine(surface ? "surface" : "sphere");
        reference->set_source(view);
        for (std::size_t i = 0; i + 1 < poses.size(); i += 2) {
            std::array<FloatImage, 2> depths;
            std::array<EyeView, 2> eyes;
            targets.size_for(eye_camera, 2);
            for (int k = 0; k < 2; ++k) {
                const Pose& pose = poses[i + std::size_t(k)];
                depths[std::size_t(k)] = depth_from(distance, eye_camera, pose);
                eyes[std::size_t(k)] = {eye_camera, pose, depths[std::size_t(k)].view()};
                targets.upload_depth(k, eye_camera, depths[std::size_t(k)].view());
            }
            resample.reproject(view, textures, eyes, targets.depth(), targets);
            for (int k = 0; k < 2; ++k) {
                EyePicture expected, found;
                reference->reproject(eyes[std::size_t(k)], expected);
                targets.download(k, found);
                EXPECT_GT(psnr_where_seen(expected, found), 55) << "eye " << i + k;
                // Of 36,000 pixels; a point on the edge of what a tolerance allows falls on either side.
                EXPECT_LE(other_origins(expected, found), 12) << "eye " << i + k;
            }
        }
    }
};

TEST_F(GlResample, ShowsWhatTheReferenceShows) {
    const SurfaceScene scene = furnished();
    for (const Camera& camera : engine_sources(720)) {
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        for (const bool surface : {false, true}) {
            SCOPED_TRACE(std::to_string(width_of(camera)) + (surface ? " surface" : " sphere"));
            expect_reference(surface, source.source(0.11), scene, engine_eyes());
        }
    }
}

TEST_F(GlResample, FromTheSourcesOwnPlaceNeedsNoDepth) {
    const Rendered source = render(hall, smooth_colour, EquirectCamera{720, 360, {}}, Pose{});
    SourceView view = source.source(0.11);
    view.depth_m = {};
    const std::array<Pose, 2> turned = {Pose{{0, 0, 0}, yaw_pitch(3, 0.4)}, Pose{{0, 0, 0}, yaw_pitch(-1, -1.5)}};
    expect_reference(true, view, hall, turned);
}

/// Patches of which nothing is known, over the sky too, are no part of what is seen around them.
TEST_F(GlResample, SamplesOfUnknownDepthAreOfNoSurface) {
    const SurfaceScene scene = furnished();
    for (const Camera& camera : engine_sources(720)) {
        SCOPED_TRACE(width_of(camera));
        Rendered source = render(scene, smooth_colour, camera, Pose{{0, 0, 0}, yaw_pitch(0.7, 0.1)});
        for (int y = 0; y < source.depth_m.height(); ++y)
            for (int x = 0; x < source.depth_m.width(); ++x)
                if ((x / 9 + y / 7) % 4 == 0)
                    *source.depth_m.pixel(x, y) = std::nanf("");
        expect_reference(true, source.source(0.11), scene, engine_eyes());
    }
}

/// A thin wall between the source and the eyes: both see the same points, each from its side, and so finely that their
/// depths agree.
TEST_F(GlResample, BacksOfSurfacesAreGaps) {
    const Distance thin_wall = [](const glm::dvec3& o, const glm::dvec3& d) {
        const double wall = to_plane(o, d, {1, 0, 0}, 0.1);
        return std::min(wall, to_plane(o, d, {0, 0, 1}, -4));
    };
    const Rendered source = render(thin_wall, smooth_colour, EquirectCamera{2880, 1440, {}}, Pose{});
    const std::array<Pose, 2> beyond = {Pose{{0.14, 0, 0}, yaw_pitch(0.3, 0)}, Pose{{0.15, 0.01, 0}, yaw_pitch(0, 0)}};
    expect_reference(true, source.source(0.15), thin_wall, beyond);
}

/// Colours of no two neighbours alike mix across the seam and the poles as everywhere.
TEST_F(GlResample, MixesAcrossSeamAndPoles) {
    std::mt19937 random(5);
    ByteImage rgb(64, 32, 3);
    for (std::uint8_t& sample : rgb.samples())
        sample = std::uint8_t(random());
    const SourceView view{.rgb = rgb.view(), .camera = EquirectCamera{64, 32, {}}};
    gl::SourceTextures textures;
    textures.upload(view);
    gl::Resample resample(gl::ResampleRule::direction, default_error_budget_px);
    gl::TargetsWithDepth targets;
    targets.size_for(eye_camera, 2);
    const auto reference = plain::make_engine("sphere");
    reference->set_source(view);
    for (const double pitch : {0.0, 1.5, -1.5}) {
        const std::array<EyeView, 2> eyes = {EyeView{eye_camera, {{0, 0, 0}, yaw_pitch(pi, pitch)}, {}},
                                             EyeView{eye_camera, {{0, 0, 0}, yaw_pitch(3, pitch)}, {}}};
        resample.reproject(view, textures, eyes, targets.depth(), targets);
        for (int k = 0; k < 2; ++k) {
            EyePicture expected, found;
            reference->reproject(eyes[std::size_t(k)], expected);
            targets.download(k, found);
            int most = 0;
            for (std::size_t i = 0; i < found.rgba.samples().size(); ++i)
                most = std::max(most, std::abs(int(found.rgba.samples()[i]) - int(expected.rgba.samples()[i])));
            EXPECT_LE(most, 3) << "pitch " << pitch << ", eye " << k << ": weights are in 128 steps";
        }
    }
}

/// Across the seam no filter mixes, so that all of this view's pixels wait for the whole rule: more than an axis of
/// work groups has invocations.
TEST_F(GlResample, MorePixelsMayWaitThanAnAxisOfWorkGroupsHas) {
    constexpr int side = 4100;
    static_assert(side * side > 65535 * 256);
    constexpr int left = 200, right = 40;
    ByteImage rgb(2, 64, 3, right);
    for (int y = 0; y < rgb.height(); ++y)
        std::ranges::fill_n(rgb.pixel(1, y), 3, std::uint8_t(left));
    const SourceView view{.rgb = rgb.view(), .camera = EquirectCamera{2, 64, {}}};
    gl::SourceTextures textures;
    textures.upload(view);
    gl::Resample resample(gl::ResampleRule::direction, default_error_budget_px);
    gl::TargetsWithDepth targets;
    const EyeView eye{PerspectiveCamera{side, side, pi / 2}, {{0, 0, 0}, yaw_pitch(pi, 0)}, {}};
    targets.size_for(eye.camera, 1);
    resample.reproject(view, textures, {&eye, 1}, targets.depth(), targets);
    EyePicture found;
    targets.download(0, found);
    int most = 0;
    for (int x = 0; x < side; ++x) {
        const double share = 0.5 + std::atan((x + 0.5) / (side / 2) - 1) / pi, expected = left + share * (right - left);
        for (int y = 0; y < side; ++y)
            most = std::max(most, int(std::abs(found.rgba.pixel(x, y)[1] - expected)));
    }
    EXPECT_LE(most, 1);
}

/// A view without depth does not look up by that of the view before; a pass that finds it starts from unknown.
TEST_F(GlResample, DepthDoesNotOutliveItsView) {
    const ByteImage rgb(64, 32, 3);
    const FloatImage depth_m(64, 32, 1, 2.5f);
    SourceView view{.rgb = rgb.view(), .camera = EquirectCamera{64, 32, {}}, .depth_m = depth_m.view()};
    gl::SourceTextures textures;
    const auto held = [&] {
        FloatImage found(64, 32, 1);
        gl::download(textures.depth(), 0, textures.size(), {GL_RED, GL_FLOAT, sizeof(float)}, found.samples().data(),
                     64 * sizeof(float));
        return found;
    };
    textures.upload(view);
    ASSERT_NE(textures.depth(), 0u);
    EXPECT_TRUE(std::ranges::equal(held().samples(), depth_m.samples()));
    view.depth_m = {};
    textures.upload(view);
    EXPECT_EQ(textures.depth(), 0u);
    EXPECT_NE(textures.depth_to_write(), 0u);
    EXPECT_TRUE(std::ranges::all_of(held().samples(), [](float r) { return std::isnan(r); }));
}

/// From a decoder's planes the colours are those of the RGB that the CPU makes of them, bit for bit.
TEST_F(GlResample, ADecodersPlanesAreTheirRgb) {
    std::mt19937 random(11);
    ByteImage y(96, 48, 1), cb(48, 24, 1), cr(48, 24, 1), rgb(96, 48, 3);
    for (ByteImage* plane : {&y, &cb, &cr})
        for (std::uint8_t& sample : plane->samples())
            sample = std::uint8_t(random());
    SourceView planes{.yuv = {y.view(), cb.view(), cr.view()}, .camera = EquirectCamera{96, 48, {}}};
    for (int row = 0; row < 48; ++row)
        for (int column = 0; column < 96; ++column)
            std::ranges::copy(yuv_to_rgb::rgb_at(planes.yuv, column, row), rgb.pixel(column, row));
    for (const gl::PlaneReader reader : {gl::PlaneReader::cpu, gl::PlaneReader::gpu}) {
        gl::SourceTextures textures(reader);
        textures.upload(planes);
        ByteImage found(96, 48, 3);
        glPixelStorei(GL_PACK_ALIGNMENT, 1);
        glGetTextureImage(textures.colour(), 0, GL_RGB, GL_UNSIGNED_BYTE, GLsizei(found.samples().size()),
                          found.samples().data());
        EXPECT_TRUE(std::ranges::equal(found.samples(), rgb.samples())) << int(reader);
    }
}

}  // namespace
}  // namespace equistream::test
