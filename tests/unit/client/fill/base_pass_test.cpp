/// The pass `base`: what lies beyond a window is shown from the sphere around it.
#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>

#include <equistream/window.h>

#include <client/pipeline/cpu_pipeline.h>
#include <client/stages/stages.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream::test {
namespace {

using glm::dvec3;

/// Both eyes' middle before a wall of smooth colour, in a window that ends within what they see.
struct WindowScene {
    static constexpr WindowGrid grid{1536, 768, 320, 256};
    Pose centre;
    PerspectiveCamera camera{320, 200, pi / 2};
    Pose turned{{0.0315, 0, 0}, glm::angleAxis(-0.4, dvec3(0, 1, 0))};
    EquirectCamera window_of = window_camera(grid, window_around(grid, {0, 0, -1}));
    Rendered window = render(wall_alone, red_and_smooth, window_of, centre);
    Rendered base = render(wall_alone, red_and_smooth, EquirectCamera{384, 192, {}}, centre);
    Rendered truth = render(wall_alone, red_and_smooth, camera, turned);
    SourceView window_view = window.source(0.0315), base_view = base.source(0.0315);
    EyePicture picture;

    /// `darker`: the base's colours are so much darker, so that a border would show.
    void show(std::string_view engine, bool eye_has_depth, int darker = 0) {
        if (engine == "rotation")
            base_view.depth_m = {};
        if (darker > 0)
            for (std::uint8_t& value : base.rgb.samples())
                value = std::uint8_t(std::max(0, value - darker));
        const EyeView eye{camera, turned, eye_has_depth ? truth.depth_m.view() : ImageView<const float>{}};
        const auto made = make_engine(engine);
        made->set_source(window_view);
        made->reproject(eye, picture);
        BaseEngine base_engine(engine, {});
        base_engine.set_base(base_view);
        const FillChain chain = make_fill_chain("base");
        chain[0]->set_frame({.main = &window_view, .base = &base_view, .base_engine = &base_engine});
        if (has_hole)
            for (int y = 80; y < 90; ++y)
                std::fill_n(picture.origin.pixel(60, y), 20, std::uint8_t{0});
        before = picture;
        Gaps gaps(picture.origin.view());
        const std::int64_t filled = chain[0]->fill(eye, picture, gaps);
        EXPECT_EQ(filled, picture.count(PixelOrigin::base));
        EXPECT_EQ(pixels_of(gaps), picture.count(PixelOrigin::gap));
    }
    EyePicture before;      ///< as the engine left it
    bool has_hole = false;  ///< well within the window
};

TEST(BasePass, ShowsWhatLiesBeyondTheWindow) {
    for (const auto& [engine, eye_has_depth] : {std::pair("eye-depth", true), {"mesh", false}}) {
        SCOPED_TRACE(engine);
        WindowScene scene;
        scene.show(engine, eye_has_depth);
        EXPECT_GT(scene.picture.count(PixelOrigin::base), 5000);
        EXPECT_LT(scene.picture.count(PixelOrigin::gap), 200);
        int worst = 0;
        for (int y = 0; y < scene.camera.height; ++y)
            for (int x = 0; x < scene.camera.width; ++x)
                if (*scene.picture.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap))
                    for (int c = 0; c < 3; ++c)
                        worst = std::max(worst,
                                         std::abs(scene.picture.rgba.pixel(x, y)[c] - scene.truth.rgb.pixel(x, y)[c]));
        EXPECT_LE(worst, 4) << evidence(scene.picture.rgb().view(), scene.truth.rgb.view());
    }
}

/// Of a window behind the head, by each engine and with all that comes before and after.
TEST(BasePass, ShowsBeyondTheWindowWhatTheBaseAloneGives) {
    const Pose centre;
    const auto picture = [&](const Camera& camera, const Pose& pose) {
        const Rendered rendered = render(ball_and_wall, red_and_smooth, camera, pose);
        ReceivedPicture made;
        made.info.camera = camera;
        made.info.camera_pose = pose;
        made.rgb = rendered.rgb;
        made.depth_m = rendered.depth_m;
        return made;
    };
    const PerspectiveCamera camera{320, 200, pi / 2};
    ReceivedFrame frame, alone;
    frame.main = picture(window_camera(WindowScene::grid, window_around(WindowScene::grid, {0, 0, 1})), centre);
    frame.base = alone.main = picture(EquirectCamera{384, 192, {}}, centre);
    PipelineEye left, right;
    left.camera = right.camera = camera;
    left.pose.position_m = {-0.06, 0.01, 0};
    right.pose.position_m = {0.06, 0.01, 0};
    for (const PipelineEye* eye : {&left, &right})
        frame.depth_views.push_back(picture(camera, eye->pose));
    alone.depth_views = frame.depth_views;
    for (const EngineStage& engine : engine_stages()) {
        SCOPED_TRACE(engine.name);
        CpuPipeline pipeline;
        pipeline.use(PipelineWays{.engine = std::string(engine.name)});
        pipeline.offer_planes();
        PipelineTimes times;
        pipeline.render(alone, left, right, 0, times);
        const std::array expected = {left.picture, right.picture};
        pipeline.render(frame, left, right, 0, times);
        for (const auto& [found, of_base] :
             {std::pair(&left.picture, &expected[0]), std::pair(&right.picture, &expected[1])}) {
            EXPECT_TRUE(std::ranges::equal(found->rgba.samples(), of_base->rgba.samples()))
                << evidence(found->rgb().view(), of_base->rgb().view());
            EXPECT_EQ(found->count(PixelOrigin::base), of_base->count(PixelOrigin::source));
            EXPECT_EQ(found->count(PixelOrigin::source), 0);
            EXPECT_EQ(of_base->count(PixelOrigin::push_pull) > 0, engine.needs.any() && engine.name != "mesh-plain")
                << "the ball hides some of the wall";
        }
    }
}

/// The largest step between pixels side by side of a row.
int max_step(const ByteImage& rgba, const ByteImage& origin) {
    int largest = 0;
    for (int y = 0; y < rgba.height(); ++y)
        for (int x = 1; x < rgba.width(); ++x)
            if (*origin.pixel(x, y) != 0 && *origin.pixel(x - 1, y) != 0)
                largest = std::max(largest, std::abs(rgba.pixel(x, y)[1] - rgba.pixel(x - 1, y)[1]));
    return largest;
}

TEST(BasePass, LeavesNoBorderToBeSeen) {
    for (const auto& [engine, eye_has_depth] : {std::pair("eye-depth", true), {"mesh", false}, {"rotation", false}}) {
        SCOPED_TRACE(engine);
        WindowScene alike, darker;
        alike.show(engine, eye_has_depth);
        darker.show(engine, eye_has_depth, 40);
        const int without = max_step(alike.picture.rgba, alike.picture.origin);
        EXPECT_LE(max_step(darker.picture.rgba, darker.picture.origin), without + 6)
            << "40 of 255 in one step, or over 8 pixels";
        EXPECT_GT(max_step(darker.picture.rgba, darker.picture.origin), without) << "the test sees the border";
    }
}

TEST(BasePass, TouchesNothingWellWithinTheWindow) {
    WindowScene scene;
    scene.show("eye-depth", true, 40);
    std::int64_t untouched = 0;
    for (std::size_t i = 0; i < scene.picture.origin.samples().size(); ++i)
        untouched += std::equal(&scene.picture.rgba.samples()[4 * i], &scene.picture.rgba.samples()[4 * i] + 4,
                                &scene.before.rgba.samples()[4 * i]);
    EXPECT_GT(untouched, 0.5 * double(scene.picture.origin.samples().size()));
}

TEST(BasePass, WhatIsWhiteOnBothSidesStaysWhite) {
    WindowScene scene;
    for (ByteImage* rgb : {&scene.window.rgb, &scene.base.rgb})
        std::ranges::fill(rgb->samples(), std::uint8_t{255});
    scene.show("eye-depth", true);
    for (std::size_t i = 0; i < scene.picture.origin.samples().size(); ++i)
        for (std::size_t c = 0; c < 3 && scene.picture.origin.samples()[i] != 0; ++c)
            ASSERT_EQ(scene.picture.rgba.samples()[4 * i + c], 255) << i;
}

/// A window that holds a pole has no border there.
TEST(BasePass, MixesNothingInAtAPoleWithinTheWindow) {
    for (const double up : {1.0, -1.0}) {
        WindowScene scene;
        scene.window_of = window_camera(WindowScene::grid, window_around(WindowScene::grid, {0, up, -1e-3}));
        scene.window = render(wall_alone, red_and_smooth, scene.window_of, scene.centre);
        scene.window_view = scene.window.source(0.0315);
        std::ranges::fill(scene.window.rgb.samples(), std::uint8_t{200});
        std::ranges::fill(scene.base.rgb.samples(), std::uint8_t{100});
        scene.turned = {{0, 0, 0}, yaw_pitch(0, up * 0.45 * pi)};
        scene.show("rotation", false);
        const int ahead = 160, pole = 100 - int(up * 160 * std::tan(0.05 * pi));
        for (int away = 2; away <= 4; ++away)
            EXPECT_EQ(scene.picture.rgba.pixel(ahead, pole + int(up) * away)[1], 200) << up << ' ' << away;
        EXPECT_GT(scene.picture.count(PixelOrigin::base), 0);
    }
}

/// Mirrors within the window are for other passes, and so are gaps of views that see nothing beyond it.
TEST(BasePass, LeavesMirrorsAndViewsWithoutABorderAlone) {
    for (const float mirror : {0.0f, 1.0f}) {
        WindowScene scene;
        const FloatImage mask(320, 256, 1, mirror);
        scene.window_view.specular = mask.view();
        scene.has_hole = true;
        scene.show("eye-depth", true);
        EXPECT_EQ(*scene.picture.origin.pixel(70, 85), std::uint8_t(mirror > 0 ? PixelOrigin::gap : PixelOrigin::base));
        EXPECT_EQ(*scene.picture.origin.pixel(310, 100), std::uint8_t(PixelOrigin::base));
    }
    WindowScene within;  // 17 degrees to each side, of a window of 37 by 30
    within.camera = {160, 100, 0.6};
    within.turned = {};
    within.has_hole = true;
    within.show("rotation", false);
    EXPECT_EQ(within.picture.count(PixelOrigin::base), 0);
}

}  // namespace
}  // namespace equistream::test
