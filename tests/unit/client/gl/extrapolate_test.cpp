/// Pictures extrapolated by the GPU and by the CPU (extrapolate.h).
#include "gl_fixture.h"

#include <client/extrapolate/gl/picture_extrapolator.h>
#include <tests/unit/client/moving_ball.h>

#include <client/extrapolate/extrapolate.h>
#include <client/receive/receive.h>

#include <cmath>
#include <vector>

namespace equistream::test {
namespace {

using moving_ball::look;
using moving_ball::sphere;
using moving_ball::turned;

class GlExtrapolate : public Gl {
protected:
    struct Carried {
        ByteImage rgb, regions;
        FloatImage depth_m, specular, virtual_depth_m;
    };

    Carried on_the_gpu(const moving_ball::Picture& picture, double seconds) {
        gl::SourceTextures source;
        const SourceView view = source_view(picture.received, picture.depth_m);
        source.upload(view);
        gl::SpecularTextures specular;
        specular.upload(view);
        extrapolator.set_picture(picture.received.info);
        extrapolator.extrapolate(source, specular, 3 * seconds);  // what it leaves must not show
        extrapolator.extrapolate(source, specular, seconds);
        const gl::Size size = source.size();
        Carried extrapolated{ByteImage(size.width, size.height, 3),
                             ByteImage(size.width, size.height, 1),
                             FloatImage(size.width, size.height, 1),
                             {},
                             {}};
        const auto width = std::size_t(size.width);
        gl::download(extrapolator.extrapolated().colour(), 0, size, {GL_RGB, GL_UNSIGNED_BYTE, 3},
                     extrapolated.rgb.samples().data(), 3 * width);
        const auto download = [&](GLuint texture, FloatImage& to) {
            to = FloatImage(size.width, size.height, 1);
            gl::download(texture, 0, size, {GL_RED, GL_FLOAT, sizeof(float)}, to.samples().data(),
                         width * sizeof(float));
        };
        download(extrapolator.extrapolated().depth(), extrapolated.depth_m);
        EXPECT_EQ(extrapolator.extrapolated_specular().has_mask(), specular.has_mask());
        if (specular.has_mask()) {
            download(extrapolator.extrapolated_specular().mask(), extrapolated.specular);
            download(extrapolator.extrapolated_specular().virtual_depth(), extrapolated.virtual_depth_m);
        }
        gl::download(extrapolator.regions(), 0, size, {GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1},
                     extrapolated.regions.samples().data(), width);
        return extrapolated;
    }

    /// What was a mirror is one where it came to, and the image in it is as far behind it as it was.
    static void expect_same_mirrors(const moving_ball::Picture& picture, const Carried& found,
                                    const ReceivedPicture& expected) {
        int changed = 0, others = 0;
        for (std::size_t i = 0; i < found.specular.samples().size(); ++i) {
            const float mask = expected.specular.samples()[i], image_m = expected.virtual_depth_m.samples()[i];
            changed += mask != picture.received.specular.samples()[i];
            others += found.specular.samples()[i] != mask ||
                      !(std::abs(found.virtual_depth_m.samples()[i] - image_m) <= 1e-4f * std::abs(image_m));
        }
        EXPECT_GT(changed, 100);
        EXPECT_LE(double(others), 0.02 * double(changed));
    }

    /// Both pictures alike; colours over what moved before or afterwards to 50 dB.
    void expect_same(const moving_ball::Picture& picture, double seconds) {
        const Carried found = on_the_gpu(picture, seconds);
        PictureExtrapolator cpu;
        ExtrapolatedPicture expected;
        cpu.extrapolate(picture.received, picture.depth_m, seconds, expected);
        if (!picture.received.specular.empty())
            expect_same_mirrors(picture, found, expected.picture);
        double squares = 0, held_squares = 0;
        std::int64_t moving = 0, other_depths = 0, shown = 0, uncovered = 0;
        for (int y = 0; y < found.rgb.height(); ++y)
            for (int x = 0; x < found.rgb.width(); ++x) {
                const float found_m = *found.depth_m.pixel(x, y), expected_m = *expected.depth_m.pixel(x, y);
                const float before_m = *picture.depth_m.pixel(x, y);
                const bool same =
                    std::isnan(found_m) ? std::isnan(expected_m) : std::abs(found_m - expected_m) <= 1e-4f * expected_m;
                other_depths += !same;
                shown += *found.regions.pixel(x, y) != 0;
                uncovered += std::isnan(found_m);
                if (expected_m == before_m)
                    continue;
                ++moving;
                for (int c = 0; c < 3; ++c) {
                    const double truth = expected.picture.rgb.pixel(x, y)[c];
                    squares += std::pow(found.rgb.pixel(x, y)[c] - truth, 2);
                    held_squares += std::pow(picture.received.rgb.pixel(x, y)[c] - truth, 2);
                }
            }
        const auto db = [&](double sum) { return 10 * std::log10(255 * 255 * 3 * double(moving) / (sum + 1e-9)); };
        EXPECT_GT(moving, 1000);
        EXPECT_GT(db(squares), 50);
        EXPECT_LT(db(held_squares), 30);
        EXPECT_LE(double(other_depths), 0.001 * double(moving));
        EXPECT_NEAR(double(shown), double(expected.moved_pixels), 2);
        EXPECT_NEAR(double(uncovered), double(expected.uncovered_pixels), 2);
    }

    gl::PictureExtrapolator extrapolator;
};

TEST_F(GlExtrapolate, GivesWhatTheCpuGives) {
    const glm::dvec3 behind = turned.position_m + turned.orientation * glm::dvec3(-0.1, 0.1, 1.8);
    const glm::dvec3 above = turned.position_m + turned.orientation * glm::dvec3(-0.2, 1.8, 0.05);
    const glm::dvec3 ahead = turned.position_m + turned.orientation * glm::dvec3(-0.4, 0.1, -2);
    const glm::dvec3 x = turned.orientation * glm::dvec3(1, 0, 0);
    const PerspectiveCamera flat{480, 360, 1.4};
    const struct {
        const char* what;
        moving_ball::Scene scene;
    } cases[] = {{"moves and spins", {sphere, turned, {{0.3, 0.2, -1.9}, 0.5, {1.2, 0.4, -0.5}, {0.5, 2, -1}}}},
                 {"across the seam", {sphere, turned, {behind, 0.5, 1.5 * x, {0, 1, 0}}}},
                 {"over the pole", {sphere, turned, {above, 0.5, 2.0 * x, {0, 1, 0}}}},
                 {"comes nearer", {sphere, turned, {{0.3, 0.2, -2.9}, 0.5, {0.6, 0, 6}, {0, 2, 0}}}},
                 {"in a flat view", {flat, turned, {ahead, 0.5, 2.0 * x, {0, 1, 0}}}},
                 {"behind a post", {sphere, turned, {ahead, 0.5, 3.0 * x, {0, 0, 0}}, {0.0, 0.15}}}};
    for (const auto& one : cases) {
        SCOPED_TRACE(one.what);
        expect_same(look(one.scene, 0), 0.15);
    }
}

/// Stripes of mirror, over the ball and what rests.
TEST_F(GlExtrapolate, CarriesMirrorsAlong) {
    const glm::dvec3 ahead = turned.position_m + turned.orientation * glm::dvec3(-0.4, 0.1, -2);
    moving_ball::Picture picture = look({sphere, turned, {ahead, 0.5, {1, 0.5, 0.3}, {0.3, 1, 0}}}, 0);
    FloatImage& mask = picture.received.specular;
    mask = picture.received.virtual_depth_m = FloatImage(sphere.width, sphere.height, 1);
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x) {
            *mask.pixel(x, y) = x / 16 % 3 == 0 ? 1.0f : 0.0f;
            *picture.received.virtual_depth_m.pixel(x, y) = 1.5f + *picture.depth_m.pixel(x, y);
        }
    expect_same(picture, 0.15);
}

/// Two bodies whose ways cross, the second the nearer: regions are told apart by number.
TEST_F(GlExtrapolate, TheNearerOfTwoIsSeen) {
    const moving_ball::Scene far{sphere, {}, {{-0.6, 0, -2.4}, 0.5, {4, 0, 0}, {0, 0, 0}}};
    const moving_ball::Scene near{sphere, {}, {{0.6, 0.1, -1.4}, 0.3, {-4, 0, 0}, {0, 1, 0}}};
    moving_ball::Picture both = look(far, 0);
    const moving_ball::Picture nearer = look(near, 0);
    for (const PixelRun& run : nearer.received.info.moving[0].runs)
        for (int x = run.begin; x < run.end; ++x) {
            *both.depth_m.pixel(x, run.row) = *nearer.depth_m.pixel(x, run.row);
            std::copy_n(nearer.received.rgb.pixel(x, run.row), 3, both.received.rgb.pixel(x, run.row));
        }
    both.received.info.moving.push_back(nearer.received.info.moving[0]);
    expect_same(both, 0.15);
    const Carried extrapolated = on_the_gpu(both, 0.15);
    EXPECT_EQ(*extrapolated.regions.pixel(384, 180), 2) << "both are in the middle by then";
    EXPECT_GT(std::ranges::count(extrapolated.regions.samples(), 1), 100);
}

TEST_F(GlExtrapolate, WhatRestsIsWhereThePictureShowsIt) {
    const moving_ball::Picture picture = look({sphere, turned, {{0.3, 0.2, -1.9}, 0.5, {1, 0, 0}, {0, 1, 0}}}, 0);
    extrapolator.set_picture(picture.received.info);
    extrapolator.rest();
    ByteImage regions(sphere.width, sphere.height, 1);
    gl::download(extrapolator.regions(), 0, {sphere.width, sphere.height}, {GL_RED_INTEGER, GL_UNSIGNED_BYTE, 1},
                 regions.samples().data(), std::size_t(sphere.width));
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x)
            ASSERT_EQ(*regions.pixel(x, y), *picture.ball.pixel(x, y)) << x << ' ' << y;
}

TEST_F(GlExtrapolate, MotionOfAnySizeIsSurvived) {
    for (const Camera& camera : {Camera(EquirectCamera{96, 48, {}}), Camera(PerspectiveCamera{96, 72, 1.4})})
        for (const double v : {1e3, 1e12, 3e38}) {
            moving_ball::Picture picture = look({camera, {}, {{0, 0, -2}}}, 0);
            picture.received.info.moving[0].motion = {{{v, -v, v / 3}, {0, v, -v}}, {{-v, 0, 0}, {0, v, 0}}};
            const Carried extrapolated = on_the_gpu(picture, 0.2);
            EXPECT_EQ(extrapolated.rgb.pixel(2, 2)[0], picture.received.rgb.pixel(2, 2)[0]);
        }
}

}  // namespace
}  // namespace equistream::test
