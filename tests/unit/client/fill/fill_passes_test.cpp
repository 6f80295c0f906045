#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>

#include <equistream/bound.h>
#include <equistream/rec709.h>
#include <equistream/window.h>

#include <client/pipeline/cpu_pipeline.h>
#include <client/stages/stages.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>

namespace equistream::test {
namespace {

using glm::dvec3;

constexpr EquirectCamera sphere{1024, 512, {}};

/// With the eye's depth, and with the samples drawn forward.
class BothWays : public ::testing::TestWithParam<bool> {
protected:
    BothWays() {
        if (GetParam())
            scene.forget_eye_depth();
    }
    std::string look() const { return evidence(scene.picture.rgb().view(), scene.truth.rgb.view()); }
    /// The few pixels of the ball's rim are gaps too; where nothing says so, the wall is drawn on.
    std::size_t rim() const { return GetParam() ? 12 : 0; }

    FillScene scene;
};
INSTANTIATE_TEST_SUITE_P(Depth, BothWays, ::testing::Bool(),
                         [](const auto& forward) { return std::string(forward.param ? "DrawnForward" : "OfTheEye"); });

TEST_P(BothWays, SmallViewFillsWhatItsEyeSees) {
    const Rendered small = render(ball_and_wall, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, scene.right);
    const SourceView view = small.source(0.063);
    EXPECT_GT(scene.fill("small", {.main = &scene.main_view, .small = &view}, PixelOrigin::small), 0.85);
    EXPECT_LE(scene.worst_filled(PixelOrigin::small, rim()), 8) << look();
}

TEST_P(BothWays, SmallViewWithoutDepthFillsByDirection) {
    const Rendered small = render(wall_alone, red_and_smooth, PerspectiveCamera{80, 50, pi / 2}, scene.right);
    SourceView view = small.source(0.063);
    view.depth_m = {};
    EXPECT_EQ(scene.fill("small", {.main = &scene.main_view, .small = &view}, PixelOrigin::small), 1);
    EXPECT_LE(scene.worst_filled(PixelOrigin::small, 12), 8) << "but for the ball's rim" << look();
    EXPECT_TRUE(std::ranges::equal(scene.picture.depth_m.samples(), scene.unfilled.depth_m.samples(),
                                   [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }))
        << "nothing tells how far it is";
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

TEST_P(BothWays, EarlierFrameShowsWhatTheHeadHasPassed) {
    const Rendered before = render(ball_and_wall, red_and_smooth, sphere, {{0.05, 0.01, 0}, yaw_pitch(0.3, 0)});
    const SourceView earlier[] = {before.source(0.1)};
    EXPECT_GT(scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier}, PixelOrigin::earlier), 0.97);
    EXPECT_LE(scene.worst_filled(PixelOrigin::earlier, rim()), 3) << look();
}

TEST_P(BothWays, WhatMovedSinceIsRefused) {
    // The frame before had a green ball just where the gap opens now, before the wall.
    const auto two_balls = [](const dvec3& o, const dvec3& d) {
        return std::min(ball_and_wall(o, d), to_sphere(o, d, {-0.3, 0, -1.6}, 0.25));
    };
    const auto green = [](const dvec3& p, double r) {
        return glm::length(p - dvec3(-0.3, 0, -1.6)) < 0.26 ? dvec3(0, 1, 0) : red_and_smooth(p, r);
    };
    const Rendered before = render(two_balls, green, sphere, {{0.05, 0.01, 0}, {1, 0, 0, 0}});
    const SourceView earlier[] = {before.source(0.1)};
    scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier}, PixelOrigin::earlier);
    int green_pixels = 0;
    for (int y = 0; y < 200; ++y)
        for (int x = 0; x < 320; ++x)
            green_pixels += *scene.picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::earlier) &&
                            scene.picture.rgba.pixel(x, y)[1] > 240;
    EXPECT_EQ(green_pixels, 0) << look();
}

TEST_P(BothWays, SecondLayerIsWhatLiesBehind) {
    Rendered behind = render(wall_alone, red_and_smooth, scene.main_camera, scene.left);
    for (int y = 0; y < 250; ++y)
        for (int x = 0; x < 400; ++x)
            if (*scene.main.depth_m.pixel(x, y) >= *behind.depth_m.pixel(x, y)) {
                *behind.depth_m.pixel(x, y) = std::nanf("");
                std::fill_n(behind.rgb.pixel(x, y), 3, std::uint8_t{0});
            }
    const SourceView hidden = behind.source(0.063);
    EXPECT_GT(scene.fill("hidden", {.main = &scene.main_view, .hidden = &hidden}, PixelOrigin::hidden), 0.97);
    EXPECT_LE(scene.worst_filled(PixelOrigin::hidden, rim()), 3) << look();
}

/// A second layer whose depth is off by half the budget that there is by default.
TEST(FillPasses, ATighterBudgetLeavesMoreGapsOpen) {
    FillScene scene;
    const double default_px = FillInputs{}.error_budget_px, box_m = scene.main_view.box_radius_m;
    Rendered behind = render(wall_alone, red_and_smooth, scene.main_camera, scene.left);
    for (float& depth_m : behind.depth_m.samples()) {
        const double w = bounded_inverse_depth(depth_m, box_m) + 0.5 * default_px / scene.camera.focal_px();
        depth_m = float(box_m + box_m / w);
    }
    const SourceView hidden = behind.source(box_m);
    const auto share_filled = [&](double error_budget_px) {
        scene.picture = scene.unfilled;
        return scene.fill("hidden", {.main = &scene.main_view, .hidden = &hidden, .error_budget_px = error_budget_px},
                          PixelOrigin::hidden);
    };
    EXPECT_GT(share_filled(default_px), 0.97);
    EXPECT_LT(share_filled(0.4 * default_px), 0.03);
}

TEST_P(BothWays, PatchesFillByTheirOwnPlaces) {
    Patches made;
    made.render_from(scene.left);
    const PatchesView patches = made.view(scene.left);
    EXPECT_GT(scene.fill("patches", {.main = &scene.main_view, .patches = &patches}, PixelOrigin::patches), 0.97);
    EXPECT_LE(scene.worst_filled(PixelOrigin::patches, rim()), 3) << look();
}

TEST_P(BothWays, AnUnusedSlotFillsNothing) {
    Patches made;
    made.render_from(scene.left);
    for (PatchAtlas::Slot& slot : made.atlas.slots)
        slot = {};
    const PatchesView patches = made.view(scene.left);
    EXPECT_EQ(scene.fill("patches", {.main = &scene.main_view, .patches = &patches}, PixelOrigin::patches), 0);
}

TEST_P(BothWays, DecoderPlanesGiveTheSameColours) {
    Rendered before = render(ball_and_wall, red_and_smooth, sphere, {{0.05, 0.01, 0}, {1, 0, 0, 0}});
    ByteImage luma(1024, 512, 1), cb(512, 256, 1), cr(512, 256, 1);
    using namespace bt709;
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 1024; ++x) {
            const std::uint8_t* c = before.rgb.pixel(x, y);
            const double l = kr * c[0] + kg * c[1] + kb * c[2];
            *luma.pixel(x, y) = std::uint8_t(16.5 + luma_scale * l);
            *cb.pixel(x / 2, y / 2) = std::uint8_t(128.5 + chroma_scale * (c[2] - l) / cb_divisor);
            *cr.pixel(x / 2, y / 2) = std::uint8_t(128.5 + chroma_scale * (c[0] - l) / cr_divisor);
        }
    SourceView view = before.source(0.1);
    view.rgb = {};
    view.yuv = {luma.view(), cb.view(), cr.view()};
    const SourceView earlier[] = {view};
    EXPECT_GT(scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier}, PixelOrigin::earlier), 0.97);
    // Chroma is shared by four samples: beside the ball its red spills by one of them.
    EXPECT_LE(scene.worst_filled(PixelOrigin::earlier, 40), 6) << look();

    const EyePicture from_planes = scene.picture;
    scene.picture = scene.unfilled;
    ByteImage rgb(1024, 512, 3);
    for (int y = 0; y < 512; ++y)
        for (int x = 0; x < 1024; ++x)
            std::ranges::copy(yuv_to_rgb::rgb_at(view.yuv, x, y), rgb.pixel(x, y));
    SourceView in_rgb = view;
    in_rgb.rgb = rgb.view();
    in_rgb.yuv = {};
    const SourceView earlier_in_rgb[] = {in_rgb};
    scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier_in_rgb}, PixelOrigin::earlier);
    EXPECT_TRUE(std::ranges::equal(scene.picture.rgba.samples(), from_planes.rgba.samples()));
}

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
        before = picture;
        Gaps gaps(picture.origin.view());
        chain[0]->fill(eye, picture, gaps);
    }
    EyePicture before;  ///< as the engine left it
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
int largest_step(const ByteImage& rgba, const ByteImage& origin) {
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
        const int without = largest_step(alike.picture.rgba, alike.picture.origin);
        EXPECT_LE(largest_step(darker.picture.rgba, darker.picture.origin), without + 6)
            << "40 of 255 in one step, or over 8 pixels";
        EXPECT_GT(largest_step(darker.picture.rgba, darker.picture.origin), without) << "the test sees the border";
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

TEST(FillPasses, NothingIsDoneWithoutInput) {
    FillScene scene;
    for (const char* fill_pass : {"patches", "hidden", "earlier", "small", "small-wide", "geometry", "base"}) {
        const FillChain chain = make_fill_chain(fill_pass);
        chain[0]->set_frame({.main = &scene.main_view});
        EXPECT_EQ(chain[0]->fill(scene.eye, scene.picture), 0);
    }
    EXPECT_TRUE(std::ranges::equal(scene.picture.rgba.samples(), scene.unfilled.rgba.samples()));
}

/// A checked wall and a red ball, both lit by a light that falls off to one side.
class CheckedWall : public GeometryColour {
public:
    static dvec3 base(const dvec3& p) {
        if (glm::length(p - dvec3(0, 0, -1.2)) < 0.31)
            return {0.8, 0.05, 0.05};
        const bool odd = (int(std::floor(p.x * 9)) + int(std::floor(p.y * 9))) & 1;
        return odd ? dvec3(0.7, 0.6, 0.3) : dvec3(0.2, 0.25, 0.5);
    }
    static dvec3 lit(const dvec3& p, double) {
        const dvec3 linear = base(p) * (0.6 + 0.15 * p.x);
        return {linear_to_srgb(float(linear.x)), linear_to_srgb(float(linear.y)), linear_to_srgb(float(linear.z))};
    }
    void set_time(double) override {}
    void cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) override {
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const dvec3 o(rays[i].origin_m), d(glm::normalize(dvec3(rays[i].direction)));
            const double r = ball_and_wall(o, d), wall = wall_alone(o, d);
            const dvec3 p = o + r * d;
            hits[i] = {float(r), glm::vec3(base(p)),
                       r < wall ? glm::vec3(glm::normalize(p - dvec3(0, 0, -1.2))) : glm::vec3(0, 0, 1),
                       r < wall ? 1u : 2u, true};
        }
    }
};

TEST(FillPasses, GeometryIsLitAsWhatIsSeenOfIt) {
    FillScene scene;
    scene.main = render(ball_and_wall, CheckedWall::lit, scene.main_camera, scene.left);
    scene.truth = render(ball_and_wall, CheckedWall::lit, scene.camera, scene.right);
    scene.main_view = scene.main.source(0.063);
    scene.eye.depth_m = scene.truth.depth_m.view();
    const auto engine = make_engine("surface");
    engine->set_source(scene.main_view);
    engine->reproject(scene.eye, scene.picture);
    scene.unfilled = scene.picture;
    CheckedWall geometry;
    EXPECT_GT(scene.fill("geometry", {.main = &scene.main_view, .geometry = &geometry}, PixelOrigin::geometry), 0.999);
    // The light changes by a tenth over what is asked around a gap, and samples at the checks' borders are mixed.
    EXPECT_LE(scene.worst_filled(PixelOrigin::geometry, 10), 20)
        << evidence(scene.picture.rgb().view(), scene.truth.rgb.view());
}

}  // namespace
}  // namespace equistream::test
