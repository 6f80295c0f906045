#include "fill_scene.h"
#include "filled_pictures.h"
#include "gl_fixture.h"
#include "random_picture.h"

#include <fill/gl/spread.h>

#include <array>

namespace equistream::test {
namespace {

class GlSpread : public Gl {
protected:
    /// Two eyes' pictures, filled at once, are those that the CPU fills one by one, by their own depth or by none.
    void expect_the_cpus(std::span<const EyeView, 2> eyes, std::span<const EyePicture, 2> before) {
        targets.size_for(eyes[0].camera, 2);
        const bool has_depth = eyes[0].depth_m.data != nullptr;
        for (int k = 0; k < 2; ++k) {
            upload(before[std::size_t(k)], k, targets);
            if (has_depth)
                targets.upload_depth(k, eyes[0].camera, eyes[std::size_t(k)].depth_m);
        }
        gaps.find(targets);
        const gl::EyeDepth depth = has_depth ? targets.depth() : gl::EyeDepth{};
        spread.fill({eyes, depth, gaps, targets});
        for (int k = 0; k < 2; ++k) {
            const EyePicture& open = before[std::size_t(k)];
            const EyePicture expected = filled("spread", {}, eyes[std::size_t(k)], open);
            EyePicture found;
            targets.download(k, found);
            const FilledPixels pixels = compare_filled(open, expected, found);
            EXPECT_GE(pixels.psnr_db, 50) << "eye " << k << ", " << pixels.count << " pixels";
            EXPECT_EQ(pixels.other_origins, 0) << "eye " << k << ", " << pixels.count << " pixels";
            EXPECT_TRUE(pixels.others_untouched) << "eye " << k;
        }
    }

    gl::EyeTargets targets;
    gl::GapTiles gaps;
    gl::Spread spread;
};

/// From picture to picture, whatever their sizes; with every eye's depth and with none.
TEST_F(GlSpread, FillsRandomPicturesAsTheCpuDoes) {
    std::mt19937 random(11);
    for (const auto& [width, height] : {std::pair{131, 77}, {64, 64}, {7, 5}, {200, 9}, {1, 1}, {97, 130}})
        for (int i = 0; i < 4; ++i) {
            SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
            std::array<RandomPicture, 2> made = {RandomPicture(width, height, random),
                                                 RandomPicture(width, height, random)};
            // Gaps of depths that nobody knows, and of none.
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    if (*made[0].picture.origin.pixel(x, y) == 0 && (x + y) % 5 < 2)
                        *made[0].depth_m.pixel(x, y) = (x + y) % 5 == 0 ? std::nanf("") : float(infinity);
            const PerspectiveCamera camera{width, height, 1};
            const bool known = i % 2 == 0;
            const auto depth_of = [&](const RandomPicture& picture) {
                return known ? picture.depth_m.view() : ImageView<const float>{};
            };
            const std::array<EyeView, 2> eyes = {EyeView{camera, {}, depth_of(made[0])},
                                                 EyeView{camera, {{0.2, 0, 0.1}, {1, 0, 0, 0}}, depth_of(made[1])}};
            expect_the_cpus(eyes, std::array{made[0].picture, made[1].picture});
        }
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
