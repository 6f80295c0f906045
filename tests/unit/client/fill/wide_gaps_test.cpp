#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>

#include <client/fill/gaps.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

constexpr auto gap = std::uint8_t(PixelOrigin::gap);

/// The definition in gaps.h, by flooding from every square: 1 where a gap is wide.
ByteImage flooded(const ByteImage& origin, int side) {
    const int width = origin.width(), height = origin.height();
    ByteImage wide(width, height, 1, 0);
    std::vector<std::pair<int, int>> open;
    const auto visit = [&](int x, int y) {
        if (x < 0 || y < 0 || x >= width || y >= height || *origin.pixel(x, y) != gap || *wide.pixel(x, y) != 0)
            return;
        *wide.pixel(x, y) = 1;
        open.emplace_back(x, y);
    };
    for (int y = 0; y + side <= height; ++y)
        for (int x = 0; x + side <= width; ++x) {
            bool square = true;
            for (int k = 0; k < side * side; ++k)
                square &= *origin.pixel(x + k % side, y + k / side) == gap;
            if (square)
                visit(x, y);
        }
    while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        for (int k = 0; k < 9; ++k)
            visit(x + k % 3 - 1, y + k / 3 - 1);
    }
    return wide;
}

void expect_as_flooded(const ByteImage& origin) {
    const Gaps gaps(origin.view());
    for (int side = 1; side <= 5; ++side) {
        const Gaps wide = wide_gaps(gaps, origin.width(), side);
        ByteImage marked(origin.width(), origin.height(), 1, 0);
        std::int64_t count = 0;
        for (const GapSpan& span : wide.spans())
            for (int x = span.begin; x < span.end; ++x, ++count)
                *marked.pixel(x, span.y) = 1;
        EXPECT_EQ(wide.count(), count);
        EXPECT_TRUE(std::ranges::equal(marked.samples(), flooded(origin, side).samples()))
            << origin.width() << " wide, squares of " << side;
    }
}

TEST(WideGaps, AreThoseOfAPlainFlood) {
    std::mt19937 random(11);
    for (const int width : {1, 2, 17, 64, 90})
        for (const unsigned gaps_of_ten : {1u, 3u, 5u, 7u, 9u}) {
            ByteImage origin(width, 50, 1);
            for (std::uint8_t& byte : origin.samples())
                byte = random() % 10 < gaps_of_ten ? gap : std::uint8_t(PixelOrigin::source);
            expect_as_flooded(origin);
        }
}

TEST(WideGaps, OfNoneAndOfAPictureThatIsOneGap) {
    expect_as_flooded(ByteImage(30, 20, 1, std::uint8_t(PixelOrigin::source)));
    expect_as_flooded(ByteImage(30, 20, 1, gap));
}

/// The ball uncovers a crescent, up to 17 pixels wide; single pixels are missing elsewhere.
TEST(SmallWide, LeavesWhatTheSmallViewDoesNotResolve) {
    FillScene scene;
    for (int k = 0; k < 10; ++k) {
        *scene.unfilled.origin.pixel(20 + 9 * k, 15) = gap;
        *scene.unfilled.origin.pixel(21 + 9 * k, 16) = gap;
    }
    const Rendered small = render(ball_and_wall, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, scene.right);
    const SourceView view = small.source(0.063);
    const FillInputs inputs{.main = &scene.main_view, .small = &view};
    scene.picture = scene.unfilled;
    scene.fill("small", inputs, PixelOrigin::small);
    const EyePicture all = std::exchange(scene.picture, scene.unfilled);
    EXPECT_EQ(*all.origin.pixel(20, 15), std::uint8_t(PixelOrigin::small));
    EXPECT_GT(scene.fill("small-wide", inputs, PixelOrigin::small), 0.8) << "most of the crescent";

    const ByteImage wide = flooded(scene.unfilled.origin, 2);
    for (int y = 0; y < scene.camera.height; ++y)
        for (int x = 0; x < scene.camera.width; ++x) {
            const EyePicture& expected = *wide.pixel(x, y) != 0 ? all : scene.unfilled;
            EXPECT_EQ(*scene.picture.origin.pixel(x, y), *expected.origin.pixel(x, y)) << x << ' ' << y;
            EXPECT_TRUE(std::equal(scene.picture.rgba.pixel(x, y), scene.picture.rgba.pixel(x, y) + 4,
                                   expected.rgba.pixel(x, y)));
        }
    EXPECT_EQ(*scene.picture.origin.pixel(20, 15), gap);
}

TEST(SmallWide, TakesEveryGapFromAViewAsDenseAsTheEye) {
    FillScene scene;
    *scene.unfilled.origin.pixel(20, 15) = gap;
    scene.picture = scene.unfilled;
    const Rendered dense = render(ball_and_wall, red_and_smooth, PerspectiveCamera{640, 400, pi / 2}, scene.right);
    SourceView view = dense.source(0.063);
    view.depth_m = {};
    EXPECT_EQ(scene.fill("small-wide", {.main = &scene.main_view, .small = &view}, PixelOrigin::small), 1);
}

}  // namespace
}  // namespace equistream::test
