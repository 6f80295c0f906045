#include "fill_scene.h"
#include "filled_pictures.h"
#include "gl_fixture.h"

#include <fill/gl/spread.h>

#include <array>

namespace equistream::test {
namespace {

class GlSpread : public Gl {
protected:
    /// Two eyes' pictures, filled at once, are those that the CPU fills one by one, by their own depth or by none.
    void expect_the_cpus(std::span<const EyeView, 2> eyes, std::span<const EyePicture, 2> before) {
        test::expect_the_cpus("spread", {}, 50, eyes, before, targets, [&](const gl::EyeDepth& depth) {
            gaps.find(targets);
            spread.fill({eyes, depth, gaps, targets});
        });
    }

    gl::EyeTargets targets;
    gl::GapTiles gaps;
    gl::Spread spread;
};

/// Gaps of depths that nobody knows, and of none.
std::optional<float> depth_in_gap(int x, int y) {
    if ((x + y) % 5 >= 2)
        return std::nullopt;
    return (x + y) % 5 == 0 ? std::nanf("") : float(infinity);
}

TEST_F(GlSpread, FillsRandomPicturesAsTheCpuDoes) {
    over_random_pictures(11, depth_in_gap,
                         [&](const auto& eyes, const auto& before) { expect_the_cpus(eyes, before); });
}

TEST_F(GlSpread, TheBackgroundFillsWhatTheForegroundUncovered) {
    FillScene scene;
    const std::array eyes = {scene.eye, scene.eye};
    expect_the_cpus(eyes, std::array{scene.unfilled, scene.unfilled});
    targets.download(1, scene.picture);
    EXPECT_EQ(scene.picture.count(PixelOrigin::gap), 0);
    EXPECT_LE(scene.worst_filled(PixelOrigin::neighbours), 26) << "red of the ball would show as 100 and more";
}

/// A picture's width and more of layers, and turns; an eye of nothing but gaps stays one.
TEST_F(GlSpread, GoesAsFarAsThereAreGaps) {
    const PerspectiveCamera camera{300, 40, 1};
    EyePicture maze, empty;
    maze.reset(camera);
    empty.reset(camera);
    FloatImage depth_m(300, 40, 1);
    // Walls of another depth, that leave a way at one end each.
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 300; ++x) {
            const bool wall = y % 4 == 3 && (y % 8 == 3 ? x < 295 : x > 4);
            *depth_m.pixel(x, y) = wall ? 9.0f : 3.0f;
        }
    const auto paint = [&](int x, int y, const std::array<std::uint8_t, 4>& rgba) {
        std::copy_n(rgba.data(), 4, maze.rgba.pixel(x, y));
        *maze.origin.pixel(x, y) = std::uint8_t(PixelOrigin::source);
    };
    paint(0, 0, {200, 90, 30, 255});
    paint(4, 3, {10, 60, 250, 255});  // a wall, of which nothing reaches the way as long as that goes on
    const EyeView eye{camera, {}, depth_m.view()};
    expect_the_cpus(std::array{eye, eye}, std::array{maze, empty});
    EyePicture found;
    targets.download(0, found);
    EXPECT_EQ(found.count(PixelOrigin::neighbours), 300 * 40 - 2);
    targets.download(1, found);
    EXPECT_EQ(found.count(PixelOrigin::gap), 300 * 40);
}

}  // namespace
}  // namespace equistream::test
