#include "gl_fixture.h"
#include "gl_scene.h"

#include <client/depth/gl/sphere_depth.h>
#include <equistream/bound.h>

#include <client/warp/engine.h>

#include <client/warp/gl/resample.h>
#include <tests/support/references/plain_engines.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace equistream::test {
namespace {

const EquirectCamera sphere{720, 360, {}};
const PerspectiveCamera eye_camera{320, 200, pi / 2};

FloatImage downloaded(const gl::SourceTextures& source) {
    FloatImage depth_m(sphere.width, sphere.height, 1);
    glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
    glGetTextureImage(source.depth(), 0, GL_RED, GL_FLOAT, GLsizei(depth_m.samples().size_bytes()),
                      depth_m.samples().data());
    return depth_m;
}

constexpr double box_radius_m = 0.13;
const double error_rad = default_budget_share * error_budget_rad(default_focal_length_px);

/// Of the samples that some view shows: how many, and how many are off by more than `allowed`, relatively.
struct Agreement {
    int shown = 0, off = 0;
};
Agreement agreement(const FloatImage& depth_m, const Distance& distance, const Pose& pose, double allowed) {
    Agreement found;
    for (int y = 0; y < sphere.height; ++y)
        for (int x = 0; x < sphere.width; ++x) {
            const double sample = double(depth_m.pixel(x, y)[0]);
            if (std::isnan(sample))
                continue;
            const double expected = distance(pose.position_m, pose.orientation * sphere.direction(x + 0.5, y + 0.5));
            ++found.shown;
            found.off += std::isinf(expected) ? !std::isinf(sample) : !(std::abs(sample / expected - 1) <= allowed);
        }
    return found;
}

class GlSphereDepth : public Gl {
protected:
    /// What a source's depth texture holds before anything is drawn.
    static void forget(gl::SourceTextures& source) {
        SourceView view;
        view.camera = sphere;
        const ByteImage rgb(sphere.width, sphere.height, 3);
        const FloatImage nothing(sphere.width, sphere.height, 1, std::nanf(""));
        view.rgb = rgb.view();
        view.depth_m = nothing.view();
        source.upload(view);
    }
};

TEST_F(GlSphereDepth, ACubesFacesGiveEverySample) {
    gl::DepthPass pass(ball_and_square());
    gl::SphereDepth sphere_depth(box_radius_m, error_rad);
    gl::SourceTextures source;
    forget(source);
    const Pose pose{{0.1, 0.1, -0.3}, yaw_pitch(0.7, 0.2)};
    const gl::SphereViews views = gl::cube_views(sphere, pose);
    ASSERT_EQ(views.views.size(), 6u);
    pass.draw(views.views);
    sphere_depth.resolve(pass, 0, views, pose, source);
    const FloatImage depth_m = downloaded(source);
    const Agreement rough = agreement(depth_m, ball_and_square_m, pose, 3e-3);
    EXPECT_EQ(rough.shown, sphere.width * sphere.height);
    // Outlines, a sample wide: of the square 4 x 3 m at 4 m, some 500 samples long, and of the ball.
    EXPECT_LT(rough.off, 500);
}

TEST_F(GlSphereDepth, OneViewGivesWhatEyesMayResample) {
    gl::DepthPass pass(ball_and_square());
    gl::SphereDepth sphere_depth(box_radius_m, error_rad);
    gl::SourceTextures source;
    const Pose pose{{0.1, 0.1, -0.3}, yaw_pitch(3, 0)};
    for (const double yaw : {0.0, 0.8, 3.0, -2.0})
        for (const double pitch : {0.0, 0.6, -1.3}) {
            std::array<EyeView, 2> eyes;
            for (int k = 0; k < 2; ++k) {
                const glm::dquat turn = yaw_pitch(yaw, pitch);
                eyes[std::size_t(k)] = {eye_camera,
                                        {pose.position_m + turn * glm::dvec3(0.063 * k - 0.0315, 0, 0), turn}};
            }
            const gl::SphereViews views = gl::sphere_views(sphere, pose, eyes);
            ASSERT_EQ(views.views.size(), 1u);
            forget(source);
            pass.draw(views.views);
            sphere_depth.resolve(pass, 0, views, pose, source);
            const FloatImage depth_m = downloaded(source);
            EXPECT_LT(agreement(depth_m, ball_and_square_m, pose, 3e-3).off, 400) << yaw << " " << pitch;
            // Where any pixel's point lies from the source, its samples are there.
            for (const EyeView& eye : eyes)
                for (int y = 0; y < eye_camera.height; y += 3)
                    for (int x = 0; x < eye_camera.width; x += 3) {
                        const glm::dvec3 d = eye.pose.orientation * eye_camera.direction(x + 0.5, y + 0.5);
                        const double r = std::min(ball_and_square_m(eye.pose.position_m, d), 1e6);
                        const glm::dvec3 from_source = eye.pose.position_m + r * d - pose.position_m;
                        const glm::dvec2 at = sphere.pixel(glm::conjugate(pose.orientation) * from_source);
                        const int column = std::min(int(at.x), sphere.width - 1);
                        ASSERT_FALSE(std::isnan(depth_m.pixel(column, std::min(int(at.y), sphere.height - 1))[0]))
                            << yaw << " " << pitch << ": " << x << " " << y;
                    }
        }
}

/// The sixteen samples that stand for those around a place among a whole sphere's: columns go round, rows come back
/// beyond a pole.
template <typename Visit>
void for_taps(const glm::dvec2& at, const Visit& visit) {
    const int column = int(std::floor(at.x - 0.5)), row = int(std::floor(at.y - 0.5));
    for (int j = -1; j <= 2; ++j)
        for (int i = -1; i <= 2; ++i) {
            int x = column + i, y = row + j;
            if (y < 0 || y >= sphere.height) {
                y = y < 0 ? -1 - y : 2 * sphere.height - 1 - y;
                x += sphere.width / 2;
            }
            visit((x + 2 * sphere.width) % sphere.width, y);
        }
}

/// Eyes anywhere within 6 cm that look anywhere at a ball of half a metre around the source: nothing may be nearer.
TEST_F(GlSphereDepth, EverySampleAroundWhatEyesResampleIsKnown) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1, 1);
    const Pose pose{{0.1, 0.1, -0.3}, yaw_pitch(2, 0.4)};
    SceneModel model;
    model.materials.resize(2);
    add_ball(model, glm::vec3(pose.position_m), float(gl::nearest_shown_m), 40);
    gl::DepthPass pass(model);
    gl::SphereDepth sphere_depth(box_radius_m, error_rad);
    gl::SourceTextures source;
    int one_view = 0, faces = 0;
    for (int round = 0; round < 60; ++round) {
        // Every third pair looks different ways.
        const double apart = round % 3 == 0 ? 3 : 0;
        std::array<EyeView, 2> eyes;
        const glm::dquat turn = yaw_pitch(pi * unit(random), 1.5 * unit(random));
        const PerspectiveCamera camera{120, 80 + int(40 * unit(random)), 1.3 + 0.5 * unit(random)};
        for (EyeView& eye : eyes) {
            const glm::dquat own = yaw_pitch(apart * unit(random), 0.2 * unit(random));
            const glm::dvec3 offset(unit(random), unit(random), unit(random));
            eye = {camera, {pose.position_m + 0.06 / std::sqrt(3.0) * offset, turn * own}};
        }
        const gl::SphereViews views = gl::sphere_views(sphere, pose, eyes);
        ++(views.views.size() == 1 ? one_view : faces);
        source.describe(sphere);
        source.forget_depth();
        pass.draw(views.views);
        sphere_depth.resolve(pass, 0, views, pose, source);
        const FloatImage depth_m = downloaded(source);
        int unknown = 0;
        for (const EyeView& eye : eyes)
            for (double y = 0; y <= camera.height; y += 2)
                for (double x = 0; x <= camera.width; x += 2) {
                    const glm::dvec3 d = eye.pose.orientation * camera.direction(x, y);
                    const glm::dvec3 offset = eye.pose.position_m - pose.position_m;
                    const double along = glm::dot(d, offset);
                    const double r = -along + std::sqrt(along * along - glm::dot(offset, offset) + 0.25);
                    const glm::dvec2 at = sphere.pixel(glm::conjugate(pose.orientation) * (offset + r * d));
                    for_taps(at, [&](int column, int row) { unknown += std::isnan(depth_m.pixel(column, row)[0]); });
                }
        EXPECT_EQ(unknown, 0) << round << ": " << views.views.size() << " views";
    }
    EXPECT_GT(one_view, 5);
    EXPECT_GT(faces, 5);
}

TEST_F(GlSphereDepth, WideEyesGetTheFacesOfACubeThatLooksWhereTheyLook) {
    gl::DepthPass pass(ball_and_square());
    gl::SphereDepth sphere_depth(box_radius_m, error_rad);
    gl::SourceTextures source;
    forget(source);
    const Pose pose{};
    const EyeView eye{{320, 280, 2.1}, {{0.03, 0, 0}, yaw_pitch(0.3, 0.1)}};
    const gl::SphereViews views = gl::sphere_views(sphere, pose, {&eye, 1});
    ASSERT_EQ(views.views.size(), 5u);
    pass.draw(views.views);
    sphere_depth.resolve(pass, 0, views, pose, source);
    const FloatImage depth_m = downloaded(source);
    const Agreement found = agreement(depth_m, ball_and_square_m, pose, 3e-3);
    EXPECT_GT(found.shown, sphere.width * sphere.height / 2);
    EXPECT_LT(found.off, 400);
}

/// The whole way: depth of eyes and of the source in one pass, then colour, against the CPU's engine and exact depth.
TEST_F(GlSphereDepth, EyesSeeWhatTheCpuShowsThem) {
    const Pose pose{{0.1, 0.1, -0.3}, yaw_pitch(1, 0)};
    const Rendered source = render(
        ball_and_square_m, [](const glm::dvec3& p, double r) { return std::isinf(r) ? glm::dvec3(0.5) : smooth(p, 3); },
        sphere, pose);
    std::array<EyeView, 2> eyes;
    std::array<FloatImage, 2> exact_m;
    for (std::size_t k = 0; k < 2; ++k) {
        eyes[k] = {eye_camera, {pose.position_m + glm::dvec3(0.1 * double(k) - 0.05, 0.02, 0), yaw_pitch(0.1, 0.05)}};
        exact_m[k] = FloatImage(eye_camera.width, eye_camera.height, 1);
        AnalyticDepth(ball_and_square_m).cast(eye_camera, eyes[k].pose, exact_m[k].view());
    }
    SourceView view = source.source(0.11);
    const auto reference = plain::make_engine("surface");
    reference->set_source(view);

    gl::DepthPass pass(ball_and_square());
    gl::SphereDepth sphere_depth(box_radius_m, error_rad);
    gl::SourceTextures textures;
    gl::Resample resample(gl::ResampleRule::seen, default_error_budget_px);
    gl::EyeTargets targets;
    targets.size_for(eye_camera, 2);
    SourceView colour_only = view;
    colour_only.depth_m = {};
    textures.upload(colour_only);
    const gl::SphereViews around = gl::sphere_views(sphere, pose, eyes);
    std::vector<gl::DepthViewpoint> views = {{eyes[0].camera, eyes[0].pose}, {eyes[1].camera, eyes[1].pose}};
    views.insert(views.end(), around.views.begin(), around.views.end());
    pass.draw(views);
    sphere_depth.resolve(pass, 2, around, pose, textures);
    resample.reproject(colour_only, textures, eyes, {pass.texture(), gl::DepthPass::inverse_scale()}, targets);
    for (std::size_t k = 0; k < 2; ++k) {
        EyeView eye = eyes[k];
        eye.depth_m = exact_m[k].view();
        EyePicture expected, found;
        reference->reproject(eye, expected);
        targets.download(int(k), found);
        int other_origins = 0;
        std::vector<double> squares;
        for (std::size_t i = 0; i < expected.origin.samples().size(); ++i) {
            other_origins += expected.origin.samples()[i] != found.origin.samples()[i];
            if (expected.origin.samples()[i] == 0 || found.origin.samples()[i] == 0)
                continue;
            for (std::size_t c = 0; c < 3; ++c)
                squares.push_back(std::pow(expected.rgba.samples()[4 * i + c] - found.rgba.samples()[4 * i + c], 2));
        }
        // Outlines, of the eye and of the sphere, fall to either side of a pixel's or texel's middle.
        std::ranges::sort(squares);
        squares.resize(squares.size() * 99 / 100);
        const double mean = std::accumulate(squares.begin(), squares.end(), 0.0) / double(squares.size());
        EXPECT_GT(10 * std::log10(255.0 * 255.0 / mean), 55) << k;
        // Outlines of ball and wall, some 900 pixels long, fall on either side.
        EXPECT_LT(other_origins, 300) << k;
    }
}

}  // namespace
}  // namespace equistream::test
