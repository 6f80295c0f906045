#include "filled_pictures.h"
#include "gl_fixture.h"

#include <client/fill/gl/push_pull.h>
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/client/random_picture.h>

#include <array>

namespace equistream::test {
namespace {

class GlPushPull : public Gl {
protected:
    /// Two eyes' pictures, filled at once, are those that the CPU fills one by one.
    void expect_the_cpus(const SourceView& main, std::span<const EyeView, 2> eyes,
                         std::span<const EyePicture, 2> before) {
        test::expect_the_cpus("pushpull", {.main = &main}, 55, eyes, before, targets, [&](const gl::EyeDepth& depth) {
            gaps.find(targets);
            push_pull.fill(main, eyes, depth, gaps, targets);
        });
    }

    gl::EyeTargets targets;
    gl::GapTiles gaps;
    gl::PushPull push_pull;
};

/// Gaps of depths that nobody knows.
std::optional<float> depth_in_gap(int x, int y) {
    return (x + y) % 5 == 0 ? std::optional(std::nanf("")) : std::nullopt;
}

TEST_F(GlPushPull, FillsRandomPicturesAsTheCpuDoes) {
    const SourceView main{.camera = EquirectCamera{64, 32, {}}, .box_radius_m = 0.1};
    over_random_pictures(7, depth_in_gap,
                         [&](const auto& eyes, const auto& before) { expect_the_cpus(main, eyes, before); });
}

TEST_F(GlPushPull, TheBackgroundFillsWhatTheForegroundUncovered) {
    FillScene scene;
    const std::array eyes = {scene.eye, scene.eye};
    expect_the_cpus(scene.main_view, eyes, std::array{scene.unfilled, scene.unfilled});
    targets.download(0, scene.picture);
    EXPECT_LE(scene.worst_filled(PixelOrigin::push_pull), 26) << "red of the ball would show as 100 and more";
}

/// Nothing to take colours from in one eye does not hinder the other.
TEST_F(GlPushPull, AnEyeOfNothingButGapsStaysOne) {
    std::mt19937 random(5);
    const RandomPicture made(80, 40, random);
    const PerspectiveCamera camera{80, 40, 1};
    EyePicture empty;
    empty.reset(camera);
    const EyeView eye{camera, {}, made.depth_m.view()};
    expect_the_cpus({.camera = camera, .box_radius_m = 0.1}, std::array{eye, eye}, std::array{empty, made.picture});
    EyePicture found;
    targets.download(0, found);
    EXPECT_EQ(found.count(PixelOrigin::gap), 80 * 40);
}

}  // namespace
}  // namespace equistream::test
