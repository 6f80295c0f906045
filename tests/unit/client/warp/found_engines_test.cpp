#include <tests/unit/client/engine_scenes.h>
#include <tests/unit/evidence.h>

#include <equistream/bound.h>

#include <tests/support/references/plain_engines.h>

#include <client/warp/source_depth_engine.h>
#include <gtest/gtest.h>
#include <limits>

namespace equistream::test {
namespace {

using glm::dvec3;

constexpr double box_m = 0.0315;

EyePicture seen_by(const char* engine_name, const SourceView& source, const EyeView& eye, bool reference = false) {
    // At the budget of everything else, which is tighter than the engines' own.
    const EngineOptions options{.source_depth_budget_px = default_error_budget_px};
    const auto engine = reference ? plain::make_engine(engine_name, options) : make_engine(engine_name, options);
    engine->set_source(source);
    EXPECT_FALSE(engine->needs_depth(source.pose, eye.pose).eye);
    EyePicture picture;
    engine->reproject(eye, picture);
    return picture;
}

/// What all but a share of the pixels stay below, as the angle by which the source's colour is displaced; infinite
/// where only one of the two found something.
double difference_of_depth(const EyePicture& a, const EyePicture& b, double eye_to_source_m, double outliers) {
    std::vector<double> differences;
    for (std::size_t i = 0; i < a.depth_m.samples().size(); ++i) {
        const double p = a.depth_m.samples()[i], q = b.depth_m.samples()[i];
        if (std::isnan(p) && std::isnan(q))
            continue;
        const double difference = eye_to_source_m * std::abs(1 / p - 1 / q);
        differences.push_back(std::isnan(difference) ? infinity : difference);
    }
    if (differences.empty())
        return 0;
    std::ranges::sort(differences);
    return differences[std::size_t(double(differences.size() - 1) * (1 - outliers))];
}

class FoundEngines : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Client, FoundEngines, testing::Values("splat", "mesh"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(FoundEngines, FastEqualsReference) {
    const SurfaceScene scene = furnished();
    const PerspectiveCamera view{120, 80, pi / 2};
    for (const Camera& camera : engine_sources(240)) {
        const Rendered source = render(scene, smooth_colour, camera, Pose{{0.1, 0, 0}, yaw_pitch(0.2, 0.1)});
        for (const Pose& eye : engine_eyes()) {
            const EyePicture fast = seen_by(GetParam(), source.source(box_m), {view, eye});
            const EyePicture plain = seen_by(GetParam(), source.source(box_m), {view, eye}, true);
            int masks = 0;
            for (std::size_t i = 0; i < fast.origin.samples().size(); ++i)
                masks += fast.origin.samples()[i] != plain.origin.samples()[i];
            // What lies on the very edge of a tolerance, or of a footprint, may fall either way.
            const int pixels = view.width * view.height;
            EXPECT_LE(masks, pixels / 100)
                << camera.index() << " " << eye.position_m.x << evidence(fast.rgb().view(), plain.rgb().view());
            EXPECT_LE(difference_of_depth(fast, plain, glm::distance(eye.position_m, source.pose.position_m), 0.015),
                      error_budget_rad(view.focal_px()));
        }
    }
}

/// The nearest of all surfaces' angles: how far from the eye's ray the point lies that the source shows in a direction.
double shift_rad(const SurfaceScene& scene, const Pose& eye, const dvec3& ray, const dvec3& direction) {
    double least = infinity;
    for (std::size_t i = 0; i <= scene.surfaces.size(); ++i) {
        const double r = i < scene.surfaces.size() ? scene.surfaces[i]({}, direction) : infinity;
        const dvec3 point = std::isinf(r) ? direction : r * direction - eye.position_m;
        least = std::min(least, std::acos(std::min(1.0, glm::dot(glm::normalize(point), ray))));
    }
    return least;
}

/// Whether the source sees one surface only within a pixel and a half of a direction.
bool inside_a_surface(const SurfaceScene& scene, const Camera& camera, const dvec3& direction) {
    const glm::dvec2 p = pixel_of(camera, direction);
    const auto which = [&](double u, double v) {
        const dvec3 d = direction_of(camera, u, v);
        const auto nearer = [&](const Distance& a, const Distance& b) { return a({}, d) < b({}, d); };
        const auto nearest = std::ranges::min_element(scene.surfaces, nearer);
        return std::isinf((*nearest)({}, d)) ? scene.surfaces.end() : nearest;
    };
    for (const double dv : {-1.5, 0.0, 1.5})
        for (const double du : {-1.5, 0.0, 1.5})
            if (which(p.x + du, p.y + dv) != which(p.x, p.y))
                return false;
    return true;
}

/// Every shift measured: the point of the surface that lent a pixel its colour, against the pixel's own ray. On the
/// last pixel of a surface, where it ends within that pixel is not known to better than that.
TEST_P(FoundEngines, NoColourIsDisplacedByMoreThanTheBudget) {
    const SurfaceScene scene = furnished();
    const PerspectiveCamera view{160, 100, pi / 2};
    const double budget_rad = error_budget_rad(view.focal_px());
    std::mt19937 random(5);
    for (const Camera& camera : engine_sources(720)) {
        const Rendered source = render(scene, smooth_colour, camera, Pose{});
        for (int i = 0; i < 6; ++i) {
            const Pose eye = random_eye(random, i < 4 ? box_m : 0.25);
            const EyePicture picture = seen_by(GetParam(), source.source(box_m), {view, eye});
            std::int64_t checked = 0, displaced = 0, displaced_inside = 0;
            double worst = 0;
            for (int y = 0; y < view.height; ++y)
                for (int x = 0; x < view.width; ++x) {
                    const double found_m = *picture.depth_m.pixel(x, y);
                    if (std::isnan(found_m))
                        continue;
                    const dvec3 ray = eye.orientation * view.direction(x + 0.5, y + 0.5);
                    const dvec3 from_source = std::isinf(found_m) ? ray : eye.position_m + found_m * ray;
                    const double shift = shift_rad(scene, eye, ray, glm::normalize(from_source));
                    ++checked;
                    if (shift <= budget_rad)
                        continue;
                    ++displaced;
                    if (inside_a_surface(scene, camera, from_source)) {
                        ++displaced_inside;
                        worst = std::max(worst, shift / budget_rad);
                    }
                }
            EXPECT_LE(displaced_inside, 0) << "of " << checked << ", at most " << worst << " budgets, eye " << i;
            EXPECT_LE(displaced, checked / 200);
        }
    }
}

/// From beside it the way from the nearest to the farthest depth leads past many million of such pixels.
TEST_P(FoundEngines, APictureOfAlmostNoAngleEnds) {
    const Distance dotted = [](const dvec3&, const dvec3& d) {
        return int(std::floor(2e6 * d.x)) % 2 == 0 ? 0.033 : 9;
    };
    const Rendered source = render(dotted, smooth_colour, EquirectCamera{256, 256, {-1e-6, 1e-6, -1e-6, 1e-6}}, Pose{});
    const PerspectiveCamera view{64, 64, pi / 2};
    const EyePicture picture = seen_by(GetParam(), source.source(box_m), {view, {{box_m, 0, 0}, {1, 0, 0, 0}}});
    EXPECT_GT(picture.count(PixelOrigin::gap), 64 * 64 / 2);
}

/// What the eye sees in closed form, where the picture shows something.
double worst_colour(const EyePicture& picture, const EyeView& eye, const Distance& distance) {
    double worst = 0;
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            if (*picture.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap))
                continue;
            const dvec3 ray = eye.pose.orientation * eye.camera.direction(x + 0.5, y + 0.5);
            const double r = distance(eye.pose.position_m, ray);
            const dvec3 colour = smooth_colour(std::isinf(r) ? ray : eye.pose.position_m + r * ray, r);
            for (int k = 0; k < 3; ++k)
                worst = std::max(worst, std::abs(picture.rgba.pixel(x, y)[k] - 255 * colour[k]));
        }
    return worst;
}

TEST_P(FoundEngines, AHallHasNoGapsAndItsOwnColoursFromAnywhere) {
    const Rendered source = render(hall, smooth_colour, EquirectCamera{480, 240, {}}, Pose{{0, 0, 0}, yaw_pitch(1, 0)});
    const PerspectiveCamera view{320, 200, pi / 2};
    for (const Pose& pose : engine_eyes()) {
        const EyeView eye{view, pose};
        const EyePicture picture = seen_by(GetParam(), source.source(box_m), eye);
        EXPECT_EQ(picture.count(PixelOrigin::gap), 0)
            << pose.position_m.x << evidence(picture.rgb().view(), picture.rgb().view());
        // A quarter of a pixel of the eye, and what a source pixel (4 m x 2 pi / 480) of that function bends.
        EXPECT_LT(worst_colour(picture, eye, hall), 3.0);
    }
}

/// Half a metre before a wall that was rendered from two: a pixel of the source covers four by four of the eye's.
TEST_P(FoundEngines, MagnifiedSurfacesHaveNoHoles) {
    const Distance wall = [](const dvec3& o, const dvec3& d) { return to_plane(o, d, {0.3, 0.1, 1}, -2); };
    const Rendered source = render(wall, smooth_colour, EquirectCamera{256, 128, {}}, Pose{});
    const PerspectiveCamera view{320, 200, 1.0};
    for (const dvec3& from : {dvec3(0.1, 0, -1.5), dvec3(-0.3, 0.2, -1.2), dvec3(0.5, -0.5, -1)}) {
        const EyePicture picture = seen_by(GetParam(), source.source(box_m), {view, {from, yaw_pitch(0, 0)}});
        EXPECT_EQ(picture.count(PixelOrigin::gap), 0) << from.x << evidence(picture.rgb().view(), picture.rgb().view());
    }
}

TEST_P(FoundEngines, AFloorToTheHorizonAndTheSkyHaveNoGaps) {
    const Distance floor = [](const dvec3& o, const dvec3& d) { return to_plane(o, d, {0, 1, 0}, -1.6); };
    for (const Camera& camera : {Camera(EquirectCamera{720, 360, {}}), Camera(PerspectiveCamera{640, 480, 2.4})}) {
        const Rendered source = render(floor, smooth_colour, camera, Pose{});
        for (const dvec3& move : {dvec3(0.0315, 0, 0), dvec3(0, 0.1, 0), dvec3(0.05, -0.1, -0.2)}) {
            const EyePicture picture =
                seen_by(GetParam(), source.source(box_m), {{160, 100, pi / 2}, {move, {1, 0, 0, 0}}});
            EXPECT_EQ(picture.count(PixelOrigin::gap), 0)
                << move.x << " " << move.y << evidence(picture.rgb().view(), picture.rgb().view());
        }
    }
}

/// A square sign a metre ahead, before a wall at four: an eye to the right finds a strip at its left edge uncovered
/// as wide as the two parallaxes differ.
TEST_P(FoundEngines, TheGapBesideASignHasItsKnownWidth) {
    const Distance sign = [](const dvec3& o, const dvec3& d) {
        const double t = to_plane(o, d, {0, 0, 1}, -1);
        const dvec3 p = o + t * d;
        return std::abs(p.x) < 0.3 && std::abs(p.y) < 0.3 ? t : infinity;
    };
    const Distance scene = [&](const dvec3& o, const dvec3& d) {
        return std::min(sign(o, d), to_plane(o, d, {0, 0, 1}, -4));
    };
    const PerspectiveCamera view{480, 320, pi / 2};
    for (const Camera& camera : {Camera(EquirectCamera{2048, 1024, {}}), Camera(PerspectiveCamera{900, 700, 2})}) {
        const Rendered source = render(scene, smooth_colour, camera, Pose{});
        for (const double right_m : {0.063, -0.063, 0.2}) {
            const EyePicture picture =
                seen_by(GetParam(), source.source(box_m), {view, {{right_m, 0, 0}, {1, 0, 0, 0}}});
            const double known_px = std::abs(right_m) * view.focal_px() * (1 - 0.25);
            for (int y = 100; y < 220; y += 7) {
                int gaps = 0;
                for (int x = 0; x < view.width; ++x)
                    gaps += *picture.origin.pixel(x, y) == 0;
                EXPECT_NEAR(gaps, known_px, 1.5) << right_m << " in row " << y;
            }
        }
    }
}

TEST_P(FoundEngines, GapsHaveNoDepthAndEverythingElseHas) {
    const SurfaceScene scene = furnished();
    const Rendered source = render(scene, smooth_colour, EquirectCamera{240, 120, {}}, Pose{});
    const EyePicture picture =
        seen_by(GetParam(), source.source(box_m), {{160, 100, pi / 2}, {{0.2, 0, 0}, {1, 0, 0, 0}}});
    ASSERT_GT(picture.count(PixelOrigin::gap), 0);
    ASSERT_GT(picture.count(PixelOrigin::source), 0);
    for (std::size_t i = 0; i < picture.origin.samples().size(); ++i)
        ASSERT_EQ(std::isnan(picture.depth_m.samples()[i]), picture.origin.samples()[i] == 0);
}

TEST_P(FoundEngines, NonFiniteAndAbsurdDepthsStayWhereTheyAre) {
    Rendered source = render(hall, smooth_colour, EquirectCamera{400, 200, {}}, Pose{});
    const EyeView eye{{160, 100, pi / 2}, {{0.05, 0.02, 0}, yaw_pitch(0.1, 0)}};
    const EyePicture whole = seen_by(GetParam(), source.source(box_m), eye);
    const float nan = std::nanf("");
    for (const auto& [x, y, value] : {std::tuple{200, 100, nan},
                                      {210, 100, -1.0f},
                                      {200, 80, 0.0f},
                                      {203, 120, -float(infinity)},
                                      {190, 100, 1e-30f},
                                      {230, 90, 3e38f}})
        source.depth_m.pixel(x, y)[0] = value;
    const EyePicture damaged = seen_by(GetParam(), source.source(box_m), eye);
    // Elsewhere a mesh may be cut into other cells, within the budget.
    const double budget_rad = error_budget_rad(eye.camera.focal_px());
    int changed = 0;
    for (std::size_t i = 0; i < whole.origin.samples().size(); ++i)
        changed += whole.origin.samples()[i] != damaged.origin.samples()[i] ||
                   0.054 * std::abs(1 / whole.depth_m.samples()[i] - 1 / damaged.depth_m.samples()[i]) > budget_rad;
    EXPECT_LE(changed, 6 * 25) << evidence(damaged.rgb().view(), whole.rgb().view());
}

TEST_P(FoundEngines, FromTheSourcesPlaceItTurns) {
    const Rendered source = render(hall, smooth_colour, EquirectCamera{240, 120, {}}, Pose{{1, 0, 0}, {1, 0, 0, 0}});
    const EyeView eye{{80, 60, 1.2}, {{1, 0, 0}, yaw_pitch(0.7, 0.2)}};
    const EyePicture turned = seen_by("sphere", source.source(), eye);
    const EyePicture picture = seen_by(GetParam(), source.source(), eye);
    EXPECT_FALSE(make_engine(GetParam())->needs_depth(source.pose, eye.pose).any());
    EXPECT_TRUE(std::ranges::equal(turned.rgba.samples(), picture.rgba.samples()));
}

/// The plain mesh stretches a sheet over the gap, so it has none; what it finds is the reference's.
TEST(PlainMesh, LeavesNoGapAndEqualsReference) {
    const SurfaceScene scene = furnished();
    const Rendered source = render(scene, smooth_colour, EquirectCamera{240, 120, {}}, Pose{});
    const EyeView eye{{120, 80, pi / 2}, {{0.1, 0.02, -0.05}, yaw_pitch(0.1, 0)}};
    const EyePicture fast = seen_by("mesh-plain", source.source(box_m), eye);
    const EyePicture plain = seen_by("mesh-plain", source.source(box_m), eye, true);
    EXPECT_EQ(fast.count(PixelOrigin::gap), 0);
    EXPECT_EQ(plain.count(PixelOrigin::gap), 0);
    EXPECT_LE(difference_of_depth(fast, plain, 0.12, 0.005), error_budget_rad(eye.camera.focal_px()));
    EXPECT_GT(seen_by("mesh", source.source(box_m), eye).count(PixelOrigin::gap), 50);
}

/// Single near samples before a wavy wall: each lies at the corner of four cells, whose other three corners are joined
/// and share a middle, whichever corner it is.
TEST(Mesh, ThreeJoinedCornersShareTheirMiddle) {
    const auto wavy = [](const dvec3&, const dvec3& d) { return 3 + 0.3 * std::sin(17 * d.x) * std::sin(19 * d.y); };
    Rendered source = render(wavy, smooth_colour, EquirectCamera{120, 60, {}}, Pose{});
    for (int y = 2; y < 58; y += 4)
        for (int x = 2 + y % 3; x < 118; x += 5)
            *source.depth_m.pixel(x, y) = 1;
    const EyeView eye{{960, 640, pi / 2}, {{0.03, 0.01, 0}, yaw_pitch(0.1, 0)}};
    const EyePicture fast = seen_by("mesh", source.source(box_m), eye);
    const EyePicture plain = seen_by("mesh", source.source(box_m), eye, true);
    int differ = 0;
    for (std::size_t i = 0; i < fast.origin.samples().size(); ++i)
        differ += (fast.origin.samples()[i] == 0) != (plain.origin.samples()[i] == 0);
    EXPECT_GT(plain.count(PixelOrigin::gap), 10000);
    EXPECT_LE(differ, plain.count(PixelOrigin::gap) / 500);
}

/// So wide a view that cells of the sky lie across its border with corners behind the eye.
TEST(Mesh, TheSkyReachesTheBorderOfAWideView) {
    const Distance sky = [](const dvec3&, const dvec3&) { return infinity; };
    const Rendered source = render(sky, smooth_colour, EquirectCamera{720, 360, {}}, Pose{});
    const EyeView eye{{160, 40, 2.8}, {{0.05, 0.02, 0}, {1, 0, 0, 0}}};
    const EyePicture picture = seen_by("mesh", source.source(box_m), eye);
    EXPECT_EQ(picture.count(PixelOrigin::gap), 0) << evidence(picture.rgb().view(), picture.rgb().view());
    EXPECT_TRUE(std::ranges::all_of(picture.depth_m.samples(), [](float r) { return std::isinf(r); }));
}

/// A picture of 66 columns, whose last block has three of them, and a sheet before a wall whose edge is where that
/// block begins.
struct NarrowBlock {
    static constexpr double edge_m = 30.0 / 33;  // of column 63, in the sheet
    PerspectiveCamera camera{66, 64, pi / 2};

    static double wall(const dvec3& o, const dvec3& d) { return to_plane(o, d, {0, 0, 1}, -10); }

    /// Where the eye sees the sheet before what the source saw of the wall, no column beyond these may show the wall.
    void expect_hidden(bool sheet_is_right, const Pose& eye, double first_column, double last_column) const {
        const auto is_sheet = [&](const dvec3& o, const dvec3& d, double to_sheet) {
            return (o.x + to_sheet * d.x < edge_m) != sheet_is_right;
        };
        const Distance scene = [&](const dvec3& o, const dvec3& d) {
            const double sheet = to_plane(o, d, {0, 0, 1}, -1);
            return is_sheet(o, d, sheet) ? sheet : wall(o, d);
        };
        const PerspectiveCamera view{160, 100, 1};
        const Rendered source = render(scene, smooth_colour, camera, Pose{});
        const EyePicture picture = seen_by("splat", source.source(box_m), {view, eye});
        int hiding = 0, wrong = 0;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                const dvec3 ray = eye.orientation * view.direction(x + 0.5, y + 0.5);
                const glm::dvec2 hidden = camera.pixel(eye.position_m + wall(eye.position_m, ray) * ray);
                if (!is_sheet(eye.position_m, ray, to_plane(eye.position_m, ray, {0, 0, 1}, -1)) ||
                    !(hidden.x > first_column && hidden.x < last_column))
                    continue;
                ++hiding;
                wrong += *picture.depth_m.pixel(x, y) > 5;
            }
        EXPECT_GT(hiding, 100);
        EXPECT_LE(wrong, hiding / 20);
    }
};

/// The eye came nearer, to what the second block shows, three columns before the narrow one.
TEST(Splat, TheBlockThatTheEpipoleIsInIsDrawnLast) {
    const dvec3 towards(27.0 / 33, 0, -1);
    NarrowBlock().expect_hidden(false, {0.5 * towards, yaw_pitch(std::atan(towards.x), 0)}, 63.2, 66);
}

/// The eye went back, away from there.
TEST(Splat, TheBlockThatTheAntipodeIsInIsDrawnFirst) {
    const dvec3 back(-0.41, 0, 0.5);
    NarrowBlock().expect_hidden(true, {back, yaw_pitch(std::atan((NarrowBlock::edge_m - back.x) / 1.5), 0)}, 60, 62.8);
}

/// In a hall whose radius is the sphere of pictures', leaning is exact.
TEST(Lean, IsExactInAHallOfItsRadiusAndEqualsReference) {
    const Distance ball = [](const dvec3& o, const dvec3& d) { return to_sphere(o, d, {0, 0, 0}, 2.5); };
    for (const Camera& camera : engine_sources(480)) {
        const Rendered source = render(ball, smooth_colour, camera, Pose{});
        const bool whole =
            std::holds_alternative<EquirectCamera>(camera) && std::get<EquirectCamera>(camera).range.is_full_sphere();
        for (const bool reference : {false, true}) {
            const auto lean = reference ? plain::make_engine("lean", {.proxy_radius_m = 2.5})
                                        : make_engine("lean", {.proxy_radius_m = 2.5});
            SourceView without_depth = source.source();
            without_depth.depth_m = {};
            lean->set_source(without_depth);
            for (const Pose& pose : engine_eyes()) {
                const EyeView eye{{160, 100, pi / 2}, pose};
                EyePicture picture;
                lean->reproject(eye, picture);
                EXPECT_FALSE(lean->needs_depth(source.pose, pose).any());
                EXPECT_TRUE(!whole || picture.count(PixelOrigin::gap) == 0);
                EXPECT_LT(worst_colour(picture, eye, ball), 2.0) << reference;
            }
        }
    }
}

TEST(Lean, TakesTheMedianDepthOrThreeMetres) {
    const Distance ball = [](const dvec3& o, const dvec3& d) { return to_sphere(o, d, {0, 0, 0}, 5); };
    const Rendered source = render(ball, smooth_colour, EquirectCamera{480, 240, {}}, Pose{});
    const EyeView eye{{160, 100, pi / 2}, {{0.3, 0.1, 0}, yaw_pitch(0.4, 0)}};
    EXPECT_LT(worst_colour(seen_by("lean", source.source(), eye), eye, ball), 2.0);
    SourceView without_depth = source.source();
    without_depth.depth_m = {};
    const auto three = make_engine("lean", {.proxy_radius_m = 3});
    three->set_source(without_depth);
    EyePicture expected;
    three->reproject(eye, expected);
    EXPECT_TRUE(std::ranges::equal(expected.rgba.samples(), seen_by("lean", without_depth, eye).rgba.samples()));
}

/// Caps beyond 40 degrees are 36 % of the sphere, and 56 % of its rows.
TEST(ProxySphere, CountsDirectionsAndNotPixels) {
    const EquirectCamera camera{360, 180, {}};
    FloatImage depth_m(360, 180, 1, 10.0f);
    const auto fill = [&](int from, int to, float r) { std::fill_n(depth_m.pixel(0, from), 360 * (to - from), r); };
    fill(0, 50, 1);
    fill(130, 180, 1);
    const SourceView source{.camera = camera, .depth_m = depth_m.view()};
    EXPECT_NEAR(proxy_radius_m(source, {}), 10, 1e-9);
    fill(0, 110, std::numeric_limits<float>::infinity());  // above -20 degrees: two thirds
    EXPECT_EQ(proxy_radius_m(source, {}), 3);
    EXPECT_EQ(proxy_radius_m(source, {.proxy_radius_m = 7}), 7);
}

}  // namespace
}  // namespace equistream::test
