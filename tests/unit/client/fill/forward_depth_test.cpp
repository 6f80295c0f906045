/// Surfaces of a grid's samples, drawn forward into gaps.
#include <tests/unit/client/fill_scene.h>

#include <client/fill/forward_depth.h>

#include <gtest/gtest.h>

#include <cmath>
#include <optional>

namespace equistream::test {
namespace {

using glm::dvec3;

FloatImage drawn(const SourceView& view, const EyeView& eye, const EyePicture& picture) {
    const Gaps gaps(picture.origin.view());
    SeenPoints seen;
    seen.look(eye, picture, gaps);
    const ForwardTask task{eye, gaps, picture, seen, EngineOptions{}.error_budget_px};
    draw_forward(PictureGrid(view), task);
    end_drawing(task);
    return seen.inverse_planar;
}

/// In gaps that are the whole picture, and in those of its border alone. Chords between samples are off by 3.5e-4 at
/// most; half a sample would be 3.5 %.
TEST(DrawnForward, ASmoothSurfaceIsWhereItIsAllRoundAndUpToTheBorders) {
    const auto hall = [](const dvec3& o, const dvec3& d) { return to_sphere(o, d, {0.3, -0.2, 0.5}, 4); };
    const auto grey = [](const dvec3&, double) { return dvec3(0.5); };
    const Rendered source = render(hall, grey, EquirectCamera{180, 90, {}}, {});
    const PerspectiveCamera camera{101, 67, pi / 2};
    for (const glm::dquat& turn : {yaw_pitch(0, 0), yaw_pitch(pi, 0.2), yaw_pitch(2, -0.3), yaw_pitch(-2, 0.6)})
        for (const bool border_alone : {false, true}) {
            const EyeView eye{camera, {{0.05, 0.02, -0.03}, turn}, {}};
            EyePicture picture;
            picture.reset(camera);
            for (int y = 1; border_alone && y < 66; ++y)
                std::fill_n(picture.origin.pixel(1, y), 99, std::uint8_t{1});
            const FloatImage inverse = drawn(source.source(0.1), eye, picture);
            for (int y = 0; y < 67; ++y)
                for (int x = 0; x < 101; ++x)
                    if (*picture.origin.pixel(x, y) == 0) {
                        const double r = hall(eye.pose.position_m, turn * camera.direction(x + 0.5, y + 0.5));
                        const double planar_m = r / double(radial_over_planar(camera, x, y));
                        ASSERT_NEAR(double(*inverse.pixel(x, y)) * planar_m, 1, 1e-3) << x << ' ' << y;
                    }
        }
}

/// A pixel of the source is ten of the eye's. What is behind stays where footprints meet.
TEST(DrawnForward, ALoneSampleReachesAsFarAsItsNeighboursAndTheFartherOneStays) {
    FloatImage depth_m(5, 5, 1, std::nanf(""));
    *depth_m.pixel(2, 2) = 1;
    *depth_m.pixel(3, 2) = 5;
    const SourceView view{.camera = PerspectiveCamera{5, 5, pi / 2}, .depth_m = depth_m.view(), .box_radius_m = 0.1};
    const EyeView eye{{50, 50, pi / 2}, {}, {}};
    EyePicture picture;
    picture.reset(eye.camera);
    const FloatImage inverse = drawn(view, eye, picture);
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 50; ++x) {
            const bool is_reached = y >= 15 && y < 35 && x >= 15 && x < 45;
            ASSERT_EQ(!std::isnan(*inverse.pixel(x, y)), is_reached) << x << ' ' << y;
            if (is_reached) {
                EXPECT_NEAR(*inverse.pixel(x, y), x < 25 ? 1.149 : 0.242, 0.03) << x << ' ' << y;
            }
        }
}

TEST(DrawnForward, IsTheSameWhateverTheOrderOfDrawing) {
    FillScene scene;
    scene.forget_eye_depth();
    std::ranges::fill(scene.unfilled.rgba.samples(), std::uint8_t{0});
    std::ranges::fill(scene.unfilled.origin.samples(), std::uint8_t(PixelOrigin::gap));
    std::ranges::fill(scene.unfilled.depth_m.samples(), std::nanf(""));
    // No sample is of its neighbour's surface, and footprints as coarse as these reach behind the eye.
    const auto scattered = [](const dvec3&, const dvec3& d) {
        const double noise = std::sin(1e4 * d.x + 2e4 * d.y + 3e4 * d.z);
        return 1.5 + 1.4 * noise;
    };
    const Rendered around = render(scattered, red_and_smooth, EquirectCamera{128, 64, {}}, scene.right);
    const SourceView view = around.source(0.1);
    std::optional<ByteImage> first;
    for (int i = 0; i < 100; ++i) {
        scene.picture = scene.unfilled;
        scene.fill("small", {.main = &scene.main_view, .small = &view}, PixelOrigin::small);
        if (!first)
            first = scene.picture.rgba;
        ASSERT_TRUE(std::ranges::equal(first->samples(), scene.picture.rgba.samples())) << "fill " << i;
    }
}

}  // namespace
}  // namespace equistream::test
