#include <equistream/error.h>

#include <client/fill/fill.h>
#include <client/fill/gaps.h>
#include <client/pipeline/eye_steps.h>
#include <equistream/window.h>
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

struct Case : FillScene {
    Rendered small = render(ball_and_wall, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, right);
};

TEST(Fill, SmallViewFillsWhatTheMainOneMissed) {
    Case c;
    const std::int64_t gaps = c.picture.count(PixelOrigin::gap);
    ASSERT_GT(gaps, 300);
    const EyePicture before = c.picture;
    const auto chain = make_fill_chain("small,spread");
    ASSERT_EQ(chain.size(), 2u);
    const SourceView small_view = c.small.source(0.063);
    for (const auto& fill_pass : chain)
        fill_pass->set_frame({.small = &small_view});
    const std::int64_t by_small = chain[0]->fill(c.eye, c.picture);
    EXPECT_GT(by_small, gaps * 9 / 10);
    EXPECT_EQ(c.picture.count(PixelOrigin::small), by_small);
    double worst_of_small = 0;
    int changed_elsewhere = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 320; ++x) {
            const bool small = c.picture.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::small);
            for (int k = 0; k < 3; ++k) {
                const int is = c.picture.rgba.pixel(x, y)[k];
                if (small)
                    worst_of_small = std::max(worst_of_small, std::abs(is - c.truth.rgb.pixel(x, y)[k]) / 255.0);
                else
                    changed_elsewhere += is != before.rgba.pixel(x, y)[k];
            }
        }
    // A pixel of the small view spans 3 m / 40: no ball's red, and the wall's colour nearly right.
    EXPECT_LT(worst_of_small, 0.03 + half_a_step) << evidence(c.picture.rgb().view(), c.truth.rgb.view());
    EXPECT_EQ(changed_elsewhere, 0) << evidence(c.picture.rgb().view(), before.rgb().view());
    const std::int64_t left_over = c.picture.count(PixelOrigin::gap);
    EXPECT_EQ(chain[1]->fill(c.eye, c.picture), left_over);
    EXPECT_EQ(c.picture.count(PixelOrigin::gap), 0);
}

/// The case of SurfaceEngine.AHiddenFloorIsNotTakenForTheSteepOneAboveIt, for what fill passes look up.
TEST(Fill, AHiddenFloorIsNotTakenForTheSteepOneAboveIt) {
    const auto floor_at = [](double height_m) {
        return [=](const glm::dvec3& o, const glm::dvec3& d) { return to_plane(o, d, {0, 1, 0}, height_m); };
    };
    const Rendered source = render(floor_at(-1.6), red_and_smooth, EquirectCamera{180, 90, {}}, Pose{});
    const SourceView view = source.source(0.6);
    const PerspectiveCamera camera{160, 100, pi / 2};
    const Pose pose{{0.6, 0, 0}, {1, 0, 0, 0}};
    const auto filled_nearer_than_60_m = [&](double height_m) {
        FloatImage depth_m(camera.width, camera.height, 1);
        AnalyticDepth(floor_at(height_m)).cast(camera, pose, depth_m.view());
        const auto chain = make_fill_chain("small");
        chain[0]->set_frame({.main = &view, .small = &view});
        EyePicture picture;
        picture.reset(camera);
        chain[0]->fill({camera, pose, depth_m.view()}, picture);
        int filled = 0, all = 0;
        for (std::size_t i = 0; i < depth_m.samples().size(); ++i)
            if (depth_m.samples()[i] < 60) {
                ++all;
                filled += picture.origin.samples()[i] != 0;
            }
        return std::pair(filled, all);
    };
    const auto [seen, floor] = filled_nearer_than_60_m(-1.6);
    EXPECT_EQ(seen, floor);
    EXPECT_GT(floor, 4000);
    EXPECT_EQ(filled_nearer_than_60_m(-3).first, 0);
}

/// Fill passes and engines have loops of their own for what one surface is: from one picture they take the same
/// samples.
TEST(Fill, PassesTakeTheSamplesThatEnginesTake) {
    FillScene scene;
    const EyePicture by_engine = scene.picture;
    scene.picture.reset(scene.camera);
    scene.unfilled = scene.picture;
    scene.fill("small", {.small = &scene.main_view}, PixelOrigin::small);
    int others = 0, coloured = 0, worst = 0;
    for (int y = 0; y < scene.camera.height; ++y)
        for (int x = 0; x < scene.camera.width; ++x) {
            const bool engine = *by_engine.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap);
            const bool fill_pass = *scene.picture.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap);
            others += engine != fill_pass;
            coloured += engine && fill_pass;
            if (engine && fill_pass)
                for (int c = 0; c < 3; ++c)
                    worst = std::max(
                        worst, std::abs(int(by_engine.rgba.pixel(x, y)[c]) - int(scene.picture.rgba.pixel(x, y)[c])));
        }
    EXPECT_GT(coloured, 60000);
    EXPECT_EQ(others, 0);
    EXPECT_LE(worst, 1);
}

TEST(Fill, SpreadTakesTheBackgroundsColour) {
    Case c;
    const auto chain = make_fill_chain("spread");
    chain[0]->fill(c.eye, c.picture);
    EXPECT_EQ(c.picture.count(PixelOrigin::gap), 0);
    int wrong = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 320; ++x)
            if (c.picture.origin.pixel(x, y)[0] == std::uint8_t(PixelOrigin::neighbours))
                wrong += std::abs(c.picture.rgba.pixel(x, y)[0] - c.truth.rgb.pixel(x, y)[0]) > 0.15 * 255;
    EXPECT_LE(wrong, c.picture.count(PixelOrigin::neighbours) / 50)
        << evidence(c.picture.rgb().view(), c.truth.rgb.view());
}

TEST(Fill, SpreadEndsWhereThereIsNothingToSpread) {
    EyePicture empty;
    empty.reset({8, 4, 1});
    EXPECT_EQ(make_fill_chain("spread")[0]->fill({{8, 4, 1}, {}, {}}, empty), 0);
    EXPECT_EQ(empty.count(PixelOrigin::gap), 32);
}

TEST(Fill, WithoutDepthTheSmallViewIsLookedUpByDirection) {
    Case c;
    const auto chain = make_fill_chain("small");
    SourceView small = c.small.source();
    small.depth_m = {};
    chain[0]->set_frame({.small = &small});
    EyeView eye = c.eye;
    eye.depth_m = {};
    EXPECT_GT(chain[0]->fill(eye, c.picture), 300);
    EXPECT_EQ(c.picture.count(PixelOrigin::gap), 0);
}

TEST(Fill, WithoutASmallViewThePassFillsNothing) {
    Case c;
    const auto chain = make_fill_chain("small");
    chain[0]->set_frame({});
    EXPECT_EQ(chain[0]->fill(c.eye, c.picture), 0);
}

TEST(Fill, ChainsAreNamed) {
    EXPECT_TRUE(make_fill_chain("none").empty());
    EXPECT_THROW(make_fill_chain(""), InputError);
    EXPECT_THROW(make_fill_chain("small,"), InputError);
    EXPECT_THROW(make_fill_chain("small,none"), InputError);
    EXPECT_THROW(make_fill_chain("telea"), InputError);
}

}  // namespace

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
        for (const GapSpan& span : wide.spans())
            for (int x = span.begin; x < span.end; ++x)
                *marked.pixel(x, span.y) = 1;
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

/// A head that has turned away, and back before the server knows: frames with windows ahead, then to the side.
class TurnedBack : public testing::Test {
protected:
    static constexpr WindowGrid grid{1536, 768, 320, 256};
    static constexpr EquirectCamera base_of{384, 192, {}};

    static ReceivedPicture picture(const Rendered& rendered, const Camera& camera, double time_s) {
        ReceivedPicture made;
        made.info.camera = camera;
        made.info.time_s = time_s;
        made.info.ipd_m = 0.063;
        made.rgb = rendered.rgb;
        return made;
    }
    /// Seen so long after the first one; `darker`: by so much less light.
    ReceivedFrame frame(const glm::dvec3& gaze, double time_s, int darker = 0) {
        const EquirectCamera window = window_camera(grid, window_around(grid, gaze));
        ReceivedFrame made;
        made.main = picture(render(wall_alone, red_and_smooth, window, {}), window, time_s);
        made.base = picture(render(wall_alone, red_and_smooth, base_of, {}), base_of, time_s);
        for (ByteImage* rgb : {&made.main.rgb, &made.base->rgb})
            for (std::uint8_t& value : rgb->samples())
                value = std::uint8_t(std::max(0, value - darker));
        return made;
    }
    static FloatImage depth_of(const Camera& camera) { return render(wall_alone, red_and_smooth, camera, {}).depth_m; }
    void pass(ReceivedFrame made) {
        SourceDepths depths;
        depths.main = depth_of(made.main.info.camera);
        fill_.remember(std::make_shared<const ReceivedPicture>(made.main),
                       std::make_shared<const ReceivedPicture>(*made.base), depths);
    }
    /// What an eye that looks ahead sees of a frame whose window is elsewhere.
    EyePicture look_ahead(const ReceivedFrame& shown) {
        const EyeView eye{camera_, {}, eye_depth_.view()};
        SourceDepths depths;
        depths.main = depth_of(shown.main.info.camera);
        depths.base = depth_of(shown.base->info.camera);
        const SourceView main = source_view(shown.main, depths.main);
        const auto engine = make_engine("eye-depth");
        engine->set_source(main);
        EyePicture picture;
        engine->reproject(eye, picture);
        fill_.set_frame(shown, depths, {main, shown.main.info.time_s});
        fill_.fill(eye, picture);
        return picture;
    }

    const glm::dvec3 ahead_{0, 0, -1}, aside_{0.94, 0, -0.34};
    PerspectiveCamera camera_{160, 100, 0.8};
    FloatImage eye_depth_ = render(wall_alone, red_and_smooth, camera_, {}).depth_m;
    FrameFill fill_{default_fill, nullptr};
};

TEST_F(TurnedBack, SeesTheWindowThatItLeft) {
    pass(frame(ahead_, 0));
    for (int i = 1; i <= 4; ++i)
        pass(frame(aside_, i));
    const EyePicture picture = look_ahead(frame(aside_, 5));
    EXPECT_GT(picture.count(PixelOrigin::earlier), 0.99 * 160 * 100);
    const Rendered truth = render(wall_alone, red_and_smooth, camera_, {});
    int worst = 0;
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 160; ++x)
            worst = std::max(worst, std::abs(picture.rgba.pixel(x, y)[1] - truth.rgb.pixel(x, y)[1]));
    EXPECT_LE(worst, 3);
}

TEST_F(TurnedBack, SeesTheBaseWhereLightHasChanged) {
    pass(frame(ahead_, 0));
    for (int i = 1; i <= 4; ++i)
        pass(frame(aside_, i));
    for (const int darker : {28, 40})
        EXPECT_GT(look_ahead(frame(aside_, 5, darker)).count(PixelOrigin::base), 0.9 * 160 * 100) << darker;
    EXPECT_GT(look_ahead(frame(aside_, 5, 20)).count(PixelOrigin::earlier), 0.9 * 160 * 100) << "less than 24 is noise";
}

TEST_F(TurnedBack, SeesTheBaseAfterTenSeconds) {
    pass(frame(ahead_, 0));
    for (int i = 1; i <= 4; ++i)
        pass(frame(aside_, i));
    const EyePicture picture = look_ahead(frame(aside_, 11));
    EXPECT_EQ(picture.count(PixelOrigin::earlier), 0);
    EXPECT_GT(picture.count(PixelOrigin::base), 0.99 * 160 * 100);
}

TEST_F(TurnedBack, SeesWhereItRestedLastAfterAGlance) {
    pass(frame(ahead_, 0));
    for (int i = 1; i <= 14; ++i)  // beside it, for long
        pass(frame({0.05, 0, -0.9987}, i));
    for (int i = 0; i < 3; ++i)
        pass(frame(aside_, 14.5 + 0.1 * i));
    EXPECT_GT(look_ahead(frame(aside_, 15)).count(PixelOrigin::earlier), 0.95 * 160 * 100);
}

TEST_F(TurnedBack, ForgetsWhatWasBeforeAJumpBack) {
    pass(frame(ahead_, 100));
    for (int i = 1; i <= 4; ++i)
        pass(frame(aside_, 100 + i));
    for (int i = 0; i < 4; ++i)
        pass(frame(ahead_, i));
    for (int i = 0; i < 3; ++i)
        pass(frame(aside_, 4 + 0.1 * i));
    EXPECT_GT(look_ahead(frame(aside_, 5)).count(PixelOrigin::earlier), 0.95 * 160 * 100);
}

TEST_F(TurnedBack, KeepsNoMoreThanAFewWindows) {
    for (const int windows : {5, 8}) {  // more than half a window apart; the last two are kept as any frames are
        fill_.forget();
        const auto gaze = [](int i) { return glm::dvec3(std::sin(0.7 * i), 0, -std::cos(0.7 * i)); };
        for (int i = 0; i < windows; ++i)
            pass(frame(gaze(i), 0.1 * i));
        const EyePicture picture = look_ahead(frame(gaze(windows - 1), 1));
        if (windows == 5)
            EXPECT_GT(picture.count(PixelOrigin::earlier), 0.99 * 160 * 100);
        else
            EXPECT_EQ(picture.count(PixelOrigin::earlier), 0) << "the first two had to go";
    }
}

}  // namespace
}  // namespace equistream::test
