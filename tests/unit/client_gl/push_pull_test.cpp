#include "fill_scene.h"
#include "filled_pictures.h"
#include "gl_fixture.h"
#include "random_picture.h"

#include <fill/gl/push_pull.h>

#include <array>

namespace equistream::test {
namespace {

class GlPushPull : public Gl {
protected:
    /// Two eyes' pictures, filled at once, are those that the CPU fills one by one.
    void expect_the_cpus(const SourceView& main, std::span<const EyeView, 2> eyes,
                         std::span<const EyePicture, 2> before) {
        targets.size_for(eyes[0].camera, 2);
        const bool has_depth = eyes[0].depth_m.data != nullptr;
        for (int k = 0; k < 2; ++k) {
            upload(before[std::size_t(k)], k, targets);
            if (has_depth)
                targets.upload_depth(k, eyes[0].camera, eyes[std::size_t(k)].depth_m);
        }
        gaps.find(targets);
        push_pull.fill(main, eyes, has_depth ? targets.depth() : gl::EyeDepth{}, gaps, targets);
        for (int k = 0; k < 2; ++k) {
            const EyePicture& open = before[std::size_t(k)];
            const EyePicture expected = filled("pushpull", {.main = &main}, eyes[std::size_t(k)], open);
            EyePicture found;
            targets.download(k, found);
            const FilledPixels pixels = compare_filled(open, expected, found);
            EXPECT_GE(pixels.psnr_db, 55) << "eye " << k << ", " << pixels.count << " pixels";
            EXPECT_EQ(pixels.other_origins, 0) << "eye " << k << ", " << pixels.count << " pixels";
            EXPECT_TRUE(pixels.others_untouched) << "eye " << k;
        }
    }

    gl::EyeTargets targets;
    gl::GapTiles gaps;
    gl::PushPull push_pull;
};

/// From picture to picture, whatever their sizes; with every eye's depth and with none.
TEST_F(GlPushPull, FillsRandomPicturesAsTheCpuDoes) {
    std::mt19937 random(7);
    const SourceView main{.camera = EquirectCamera{64, 32, {}}, .box_radius_m = 0.1};
    for (const auto& [width, height] : {std::pair{131, 77}, {64, 64}, {7, 5}, {200, 9}, {1, 1}, {97, 130}})
        for (int i = 0; i < 4; ++i) {
            SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
            std::array<RandomPicture, 2> made = {RandomPicture(width, height, random),
                                                 RandomPicture(width, height, random)};
            // Gaps of depths that nobody knows.
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    if (*made[0].picture.origin.pixel(x, y) == 0 && (x + y) % 5 == 0)
                        *made[0].depth_m.pixel(x, y) = std::nanf("");
            const PerspectiveCamera camera{width, height, 1};
            const bool known = i % 2 == 0;
            const auto depth_of = [&](const RandomPicture& picture) {
                return known ? picture.depth_m.view() : ImageView<const float>{};
            };
            const std::array<EyeView, 2> eyes = {EyeView{camera, {}, depth_of(made[0])},
                                                 EyeView{camera, {{0.2, 0, 0.1}, {1, 0, 0, 0}}, depth_of(made[1])}};
            expect_the_cpus(main, eyes, std::array{made[0].picture, made[1].picture});
        }
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
