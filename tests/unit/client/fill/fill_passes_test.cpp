#include <tests/unit/client/fill_scene.h>
#include <tests/unit/evidence.h>

#include <equistream/bound.h>
#include <equistream/rec709.h>

#include <client/fill/gap_resample.h>

#include <gtest/gtest.h>

#include <cmath>

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
    /// Where the picture has depths, what was filled is as far away as what is there.
    void expect_depths(PixelOrigin mark) const {
        std::size_t off = 0;
        if (scene.picture.depth_m.empty())
            return;
        for (int y = 0; y < scene.camera.height; ++y)
            for (int x = 0; x < scene.camera.width; ++x)
                if (*scene.picture.origin.pixel(x, y) == std::uint8_t(mark)) {
                    const float ratio = *scene.picture.depth_m.pixel(x, y) / *scene.truth.depth_m.pixel(x, y);
                    off += !(std::abs(ratio - 1) < 0.03f);
                }
        EXPECT_LE(off, rim());
    }
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
    expect_depths(PixelOrigin::small);
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

TEST_P(BothWays, EarlierFrameShowsWhatTheHeadHasPassed) {
    const Rendered before = render(ball_and_wall, red_and_smooth, sphere, {{0.05, 0.01, 0}, yaw_pitch(0.3, 0)});
    const SourceView earlier[] = {before.source(0.1)};
    EXPECT_GT(scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier}, PixelOrigin::earlier), 0.97);
    EXPECT_LE(scene.worst_filled(PixelOrigin::earlier, rim()), 3) << look();
    expect_depths(PixelOrigin::earlier);
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

/// What is asked of the main sphere does not change where its first and last columns meet.
TEST_P(BothWays, EarlierFramesAreAskedForAcrossTheSeamToo) {
    const EquirectCamera coarse{96, 48, {}};
    const Rendered before = render(ball_and_wall, red_and_smooth, sphere, {{0.05, 0.01, 0}, {1, 0, 0, 0}});
    const SourceView earlier[] = {before.source(0.1)};
    double share = 0;
    for (int column = 0; column <= coarse.width; column += column == 0 ? 38 : column < 58 ? 1 : 38) {
        const Pose turned{scene.left.position_m, yaw_pitch(2 * pi * column / coarse.width, 0)};
        const Rendered main = render(ball_and_wall, red_and_smooth, coarse, turned);
        // Within a box so large that a column of the wall does not stand for the next.
        const SourceView view = main.source(3);
        scene.picture = scene.unfilled;
        const double found = scene.fill("earlier", {.main = &view, .earlier = earlier}, PixelOrigin::earlier);
        if (column == 0)
            share = found;
        EXPECT_NEAR(found, share, 1e-3) << column;
    }
    EXPECT_GT(share, 0.5);
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
    expect_depths(PixelOrigin::hidden);
}

/// What lies infinitely far away has a place too.
TEST(FillPasses, SkyBehindAnEdgeIsTakenFromEarlierFrames) {
    const auto ball = [](const dvec3& o, const dvec3& d) { return to_sphere(o, d, {0, 0, -1.2}, 0.3); };
    const auto paint = [](const dvec3& p, double r) { return std::isinf(r) ? smooth(p, 1.5) : dvec3(1, 0, 0); };
    FillScene scene;
    scene.main = render(ball, paint, scene.main_camera, scene.left);
    scene.truth = render(ball, paint, scene.camera, scene.right);
    scene.look_again();
    const Rendered before = render(ball, paint, sphere, {{0.05, 0.01, 0}, {1, 0, 0, 0}});
    const SourceView earlier[] = {before.source(0.1)};
    EXPECT_GT(scene.fill("earlier", {.main = &scene.main_view, .earlier = earlier}, PixelOrigin::earlier), 0.97);
    EXPECT_LE(scene.worst_filled(PixelOrigin::earlier), 3);
}

/// Those beside something nearer: their colours may be of both.
TEST(FillPasses, UnmixedSamplesHaveNothingNearerBesideThem) {
    FillScene scene;
    const SourceView own = scene.truth.source(0.063);
    const Gaps gaps(scene.picture.origin.view());
    SeenPoints seen;
    seen.look(scene.eye, scene.picture, gaps);
    const GapResampleTask task{.eye = scene.eye,
                               .seen = seen,
                               .gaps = gaps,
                               .error_budget_px = EngineOptions{}.error_budget_px,
                               .mark = PixelOrigin::small,
                               .unmixed_only = true};
    EXPECT_GT(resample_gaps(PictureGrid(own), task, scene.picture), 100);
    const auto is_ball = [&](int x, int y) { return *scene.truth.depth_m.pixel(x, y) < 2; };
    for (const GapSpan& span : gaps.spans())
        for (int x = span.begin, y = span.y; x < span.end; ++x)
            if (!is_ball(x, y)) {
                EXPECT_EQ(*scene.picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap),
                          is_ball(x - 1, y) || is_ball(x + 1, y) || is_ball(x, y - 1) || is_ball(x, y + 1))
                    << x << ' ' << y;
            }
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
    expect_depths(PixelOrigin::patches);
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

TEST(FillPasses, NothingIsDoneWithoutInput) {
    FillScene scene;
    for (const char* fill_pass : {"patches", "hidden", "earlier", "small", "small-wide", "geometry", "base"}) {
        const FillChain chain = make_fill_chain(fill_pass);
        chain[0]->set_frame({.main = &scene.main_view});
        EXPECT_EQ(chain[0]->fill(scene.eye, scene.picture), 0);
    }
    EXPECT_TRUE(std::ranges::equal(scene.picture.rgba.samples(), scene.unfilled.rgba.samples()));
}

/// A checked wall that is lit by a light that falls off to one side, and a red ball in the shade.
class CheckedWall : public GeometryColour {
public:
    static dvec3 base(const dvec3& p) {
        if (glm::length(p - dvec3(0, 0, -1.2)) < 0.31)
            return {0.8, 0.05, 0.05};
        const bool odd = (int(std::floor(p.x * 9)) + int(std::floor(p.y * 9))) & 1;
        return odd ? dvec3(0.7, 0.6, 0.3) : dvec3(0.2, 0.25, 0.5);
    }
    static dvec3 lit(const dvec3& p, double) {
        const bool is_ball = glm::length(p - dvec3(0, 0, -1.2)) < 0.31;
        const dvec3 linear = base(p) * (is_ball ? 0.2 : 0.6 + 0.15 * p.x);
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
    scene.look_again();
    CheckedWall geometry;
    EXPECT_GT(scene.fill("geometry", {.main = &scene.main_view, .geometry = &geometry}, PixelOrigin::geometry), 0.999);
    // The light changes by a tenth over what is asked around a gap, and samples at the checks' borders are mixed.
    EXPECT_LE(scene.worst_filled(PixelOrigin::geometry, 10), 20)
        << evidence(scene.picture.rgb().view(), scene.truth.rgb.view());
}

/// A leaf with a fold in one column: that faces the eye, what is to the left of it faces aside, and what is to the
/// right nearly so.
class FoldedLeaf : public GeometryColour {
public:
    static constexpr int width = 32, fold = 11;

    void set_time(double) override {}
    void cast(std::span<const GeometryRay> rays, std::span<GeometryHit> hits) override {
        constexpr float facing = 0.234f;  // to the fourth power 0.003
        const glm::vec3 left(1, 0, 0), middle(0, 0, 1), right(std::sqrt(1 - facing * facing), 0, facing);
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const glm::vec3 d = rays[i].direction;
            const int column = int(0.5f * float(width) * (1 - d.x / d.z));
            hits[i] = {2.0f, glm::vec3(0.5f), column < fold ? left : column == fold ? middle : right, 1u, true};
        }
    }
};

/// What faces elsewhere counts for little, but never against: light is a mean of what is seen around.
TEST(FillPasses, GeometrysLightIsAMeanOfWhatIsSeen) {
    const EyeView eye{{FoldedLeaf::width, 32, pi / 2}, {}};
    constexpr std::uint8_t bright = 188, dark = 99;  // 0.5 and 0.125, linear
    EyePicture picture;
    picture.reset(eye.camera);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < FoldedLeaf::width; ++x)
            if (x != FoldedLeaf::fold) {
                std::fill_n(picture.rgba.pixel(x, y), 3, x < FoldedLeaf::fold ? bright : dark);
                picture.rgba.pixel(x, y)[3] = 255;
                *picture.origin.pixel(x, y) = std::uint8_t(PixelOrigin::source);
            }
    FoldedLeaf geometry;
    const FillChain chain = make_fill_chain("geometry");
    chain[0]->set_frame({.geometry = &geometry});
    EXPECT_EQ(chain[0]->fill(eye, picture), 32);
    for (int y = 0; y < 32; ++y)
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(picture.rgba.pixel(FoldedLeaf::fold, y)[c], 124, 3) << "one part of 0.5, four of 0.125";
}

}  // namespace
}  // namespace equistream::test
