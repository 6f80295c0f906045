#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/evidence.h>

#include <tests/support/references/plain_engines.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

using glm::dvec3;

constexpr double frequency = 1.5;

std::unique_ptr<Engine> surface(bool reference = false) {
    return reference ? plain::make_engine("surface") : make_engine("surface");
}

/// A room: the inside of a sphere of 4 m, off the source's centre.
double room(const dvec3& o, const dvec3& d) {
    return to_sphere(o, d, {0.3, -0.2, 0.5}, 4);
}

/// A floor 1.6 m down and the sky above it.
double floor_and_sky(const dvec3& o, const dvec3& d) {
    return to_plane(o, d, {0, 1, 0}, -1.6);
}

/// A ball of 0.4 m, 1.5 m ahead, before a wall at 4 m that is tilted by 30 degrees.
double ball(const dvec3& o, const dvec3& d) {
    return to_sphere(o, d, {0.1, 0, -1.5}, 0.4);
}
double wall(const dvec3& o, const dvec3& d) {
    return to_plane(o, d, {0.5, 0, std::sqrt(0.75)}, -4 * std::sqrt(0.75));
}
double ball_and_wall(const dvec3& o, const dvec3& d) {
    return std::min(ball(o, d), wall(o, d));
}

dvec3 smooth_colour(const dvec3& p, double) {
    return smooth(p, frequency);
}

struct Eye {
    PerspectiveCamera camera{160, 100, pi / 2};
    Pose pose;
    FloatImage depth_m;

    Eye(const Distance& distance, const Pose& where, const PerspectiveCamera& what = {160, 100, pi / 2})
        : camera(what), pose(where), depth_m(what.width, what.height, 1) {
        AnalyticDepth(distance).cast(camera, pose, depth_m.view());
    }
    EyeView view() const { return {camera, pose, depth_m.view()}; }
    dvec3 ray(int x, int y) const { return pose.orientation * camera.direction(x + 0.5, y + 0.5); }
};

const std::vector<Pose> moved_eyes = {
    {{0.0315, 0, 0}, {1, 0, 0, 0}},
    {{-0.063, 0, 0}, yaw_pitch(0.5, 0.1)},
    {{0.02, 0.1, -0.05}, yaw_pitch(pi, -0.2)},
    {{0.1, -0.1, 0.2}, yaw_pitch(0.3, 1.4)},
    {{0, 0.05, 0.1}, yaw_pitch(-2.5, -1.5)},
};

/// What the eye should see in closed form, where `picture` shows something; its gaps are as it leaves them.
FloatImage exact_where_seen(const Colour& colour, const Eye& eye, const Distance& distance, const EyePicture& picture) {
    FloatImage exact = displayed(picture);
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            if (picture.origin.pixel(x, y)[0] == 0)
                continue;
            const dvec3 d = eye.ray(x, y);
            const double r = distance(eye.pose.position_m, d);
            const dvec3 c = colour(std::isinf(r) ? d : eye.pose.position_m + r * d, r);
            for (int k = 0; k < 3; ++k)
                exact.pixel(x, y)[k] = float(c[k]);
        }
    return exact;
}

class SurfaceEngine : public testing::TestWithParam<bool> {};

INSTANTIATE_TEST_SUITE_P(Client, SurfaceEngine, testing::Bool(),
                         [](const auto& test) { return test.param ? "reference" : "fast"; });

TEST_P(SurfaceEngine, MovingInsideARoomIsTheFunctionOfThePoint) {
    const Rendered source = render(room, smooth_colour, EquirectCamera{720, 360, {}}, Pose{{0, 0, 0}, yaw_pitch(1, 0)});
    const auto engine = surface(GetParam());
    engine->set_source(source.source());
    for (const Pose& pose : moved_eyes) {
        const Eye eye(room, pose);
        EyePicture picture;
        engine->reproject(eye.view(), picture);
        EXPECT_EQ(picture.count(PixelOrigin::gap), 0);
        // A source pixel spans 4 m x 2 pi / 720 of a function whose second derivative is at most frequency^2 / 2.
        const FloatImage exact = exact_where_seen(smooth_colour, eye, room, picture);
        EXPECT_LT(worst_difference(displayed(picture), exact), half_a_step + 1 / 510.0 + 0.002)
            << evidence(displayed(picture).view(), exact.view());
    }
}

/// The floor runs to the horizon at a grazing angle: no gap anywhere, sky included.
TEST_P(SurfaceEngine, GrazingFloorAndSkyHaveNoGaps) {
    const Colour checks = [](const dvec3& p, double r) { return std::isinf(r) ? dvec3(0.5) : smooth(p * 0.2, 1); };
    for (const Camera& camera : {Camera(EquirectCamera{720, 360, {}}), Camera(PerspectiveCamera{640, 480, 2.4})}) {
        const Rendered source = render(floor_and_sky, checks, camera, Pose{});
        const auto engine = surface(GetParam());
        engine->set_source(source.source());
        for (const dvec3& move : {dvec3(0.063, 0, 0), dvec3(0, 0.1, 0), dvec3(0.05, -0.1, -0.2)}) {
            const Eye eye(floor_and_sky, Pose{move, {1, 0, 0, 0}});
            EyePicture picture;
            engine->reproject(eye.view(), picture);
            EXPECT_EQ(picture.count(PixelOrigin::gap), 0) << move.x << " " << move.y << " " << move.z;
        }
    }
}

/// A floor 3 m down, hidden from the source by the one above it, whose samples run through every depth that the hidden
/// one has: where one of four has it by chance, the surface between them still tells that it lies before the point.
/// Also round the seam and about a pole.
TEST_P(SurfaceEngine, AHiddenFloorIsNotTakenForTheSteepOneAboveIt) {
    const Distance hidden = [](const dvec3& o, const dvec3& d) { return to_plane(o, d, {0, 1, 0}, -3); };
    for (const glm::dquat& turn : {yaw_pitch(0, 0), yaw_pitch(pi, -0.3), yaw_pitch(0.4, -1.4)})
        for (const Camera& camera : {Camera(EquirectCamera{180, 90, {}}), Camera(PerspectiveCamera{160, 120, 2.4})}) {
            const bool sphere = camera.index() == 0;
            const Rendered source =
                render(floor_and_sky, smooth_colour, camera, Pose{{0, 0, 0}, sphere ? yaw_pitch(0, 0) : turn});
            const auto engine = surface(GetParam());
            engine->set_source(source.source());
            const Pose pose{{0.6, 0, 0}, turn};
            EyePicture picture;
            engine->reproject(Eye(floor_and_sky, pose).view(), picture);
            EXPECT_EQ(picture.count(PixelOrigin::gap), 0) << "of the floor that is seen";
            const Eye eye(hidden, pose);
            engine->reproject(eye.view(), picture);
            int by_chance = 0, floor = 0;
            for (int y = 0; y < eye.camera.height; ++y)
                for (int x = 0; x < eye.camera.width; ++x) {
                    // Farther away the two floors come within a few budgets of each other.
                    if (!(eye.depth_m.pixel(x, y)[0] < 60))
                        continue;
                    ++floor;
                    by_chance += picture.origin.pixel(x, y)[0] != 0;
                }
            EXPECT_GT(floor, 4000);
            EXPECT_EQ(by_chance, 0) << camera.index();
        }
}

/// Which of the eye's pixels the source's centre sees, by closed form: those are 1, all others 0.
ByteImage seen(const Eye& eye, const Distance& distance, const dvec3& centre) {
    ByteImage result(eye.camera.width, eye.camera.height, 1);
    for (int y = 0; y < eye.camera.height; ++y)
        for (int x = 0; x < eye.camera.width; ++x) {
            const dvec3 p = eye.pose.position_m + double(eye.depth_m.pixel(x, y)[0]) * eye.ray(x, y);
            const double r = glm::length(p - centre);
            result.pixel(x, y)[0] = distance(centre, (p - centre) / r) > r * (1 - 1e-4);
        }
    return result;
}

/// A mask of 0 and 1 as a picture in black and white.
ByteImage black_and_white(ByteImage mask) {
    for (std::uint8_t& value : mask.samples())
        value = value != 0 ? 255 : 0;
    return mask;
}

TEST_P(SurfaceEngine, GapsAreWhatTheSourceDoesNotSee) {
    const PerspectiveCamera eye_camera{320, 200, pi / 2};
    for (const Camera& camera : {Camera(EquirectCamera{2048, 1024, {}}), Camera(PerspectiveCamera{640, 400, pi / 2})}) {
        const Rendered source = render(ball_and_wall, smooth_colour, camera, Pose{});
        const auto engine = surface(GetParam());
        engine->set_source(source.source());
        for (const dvec3& move : {dvec3(0.063, 0, 0), dvec3(-0.15, 0.05, 0), dvec3(0, 0.1, 0.05)}) {
            const Eye eye(ball_and_wall, Pose{move, {1, 0, 0, 0}}, eye_camera);
            EyePicture picture;
            engine->reproject(eye.view(), picture);
            const ByteImage visible = seen(eye, ball_and_wall, {});
            int hidden = 0, gaps = 0, both = 0;
            for (int y = 8; y < 192; ++y)
                for (int x = 40; x < 280; ++x) {
                    const bool gap = picture.origin.pixel(x, y)[0] == 0;
                    hidden += !visible.pixel(x, y)[0];
                    gaps += gap;
                    both += gap && !visible.pixel(x, y)[0];
                }
            ASSERT_GT(hidden, 100);
            EXPECT_TRUE(both > 0.9 * gaps && both > 0.85 * hidden)
                << hidden << " hidden, " << gaps << " gaps, " << both << " both"
                << evidence(black_and_white(picture.origin).view(), black_and_white(visible).view());
        }
    }
}

/// Ball red, wall blue, sampled without a filter: no pixel of the eye may be anything between.
TEST_P(SurfaceEngine, NothingBleedsAcrossASilhouette) {
    const Distance hit = ball_and_wall;
    const Colour two = [](const dvec3& p, double) {
        return glm::length(p - dvec3(0.1, 0, -1.5)) < 0.41 ? dvec3(1, 0, 0) : dvec3(0, 0, 1);
    };
    const Rendered source = render(hit, two, EquirectCamera{900, 450, {}}, Pose{});
    const auto engine = surface(GetParam());
    engine->set_source(source.source());
    for (const dvec3& move : {dvec3(0.063, 0, 0), dvec3(-0.1, 0.1, 0.1)}) {
        const Eye eye(hit, Pose{move, {1, 0, 0, 0}}, {320, 200, pi / 2});
        EyePicture picture;
        engine->reproject(eye.view(), picture);
        EXPECT_GT(picture.count(PixelOrigin::source), 300 * 200);
        const FloatImage exact = exact_where_seen(two, eye, hit, picture);
        EXPECT_LT(worst_difference(displayed(picture), exact), 1e-5)
            << evidence(displayed(picture).view(), exact.view());
    }
}

/// A leaf edge-on between the eyes: both see it at the same place, one its front and one its back.
TEST_P(SurfaceEngine, TheBackOfALeafIsNotItsFront) {
    const Distance leaf = [](const dvec3& o, const dvec3& d) {
        const double t = to_plane(o, d, {1, 0, 0.1}, 0);
        const dvec3 p = o + t * d;
        return std::abs(p.y) < 0.3 && p.z < -0.2 && p.z > -0.9 ? t : infinity;
    };
    const Distance scene = [&](const dvec3& o, const dvec3& d) {
        return std::min(leaf(o, d), to_plane(o, d, {0, 0, 1}, -4));
    };
    // The plane goes through the origin: one eye to its left, source and the other eye to its right.
    const double x_left = 0.0315, x_right = 0.1;
    const Rendered source =
        render(scene, smooth_colour, EquirectCamera{1024, 512, {}}, Pose{{x_left, 0, 0}, {1, 0, 0, 0}});
    const Eye same_side(scene, Pose{{x_left + 0.02, 0, 0}, {1, 0, 0, 0}});
    const Eye other_side(scene, Pose{{x_left - x_right, 0, 0}, {1, 0, 0, 0}});
    const auto engine = surface(GetParam());
    engine->set_source(source.source());
    for (const Eye* eye : {&same_side, &other_side}) {
        EyePicture picture;
        engine->reproject(eye->view(), picture);
        int leaf_pixels = 0, coloured = 0;
        for (int y = 0; y < eye->camera.height; ++y)
            for (int x = 0; x < eye->camera.width; ++x)
                if (std::isfinite(leaf(eye->pose.position_m, eye->ray(x, y)))) {
                    ++leaf_pixels;
                    coloured += picture.origin.pixel(x, y)[0] != 0;
                }
        ASSERT_GT(leaf_pixels, 300);
        if (eye == &same_side)
            EXPECT_GT(coloured, leaf_pixels * 9 / 10);
        else
            EXPECT_LT(coloured, leaf_pixels / 10);  // its rim stays in doubt
    }
}

TEST(Surface, FastEqualsReference) {
    const Distance hit = ball_and_wall;
    const Distance everything = [&](const dvec3& o, const dvec3& d) {
        return std::min({hit(o, d), floor_and_sky(o, d), to_sphere(o, d, {0, 0, 0}, 9)});
    };
    for (const Camera& camera : {Camera(EquirectCamera{480, 240, {}}), Camera(PerspectiveCamera{320, 240, 2})}) {
        const Rendered source = render(everything, smooth_colour, camera, Pose{{0.1, 0, 0}, yaw_pitch(0.2, 0.1)});
        const auto fast = surface(false);
        const auto reference = surface(true);
        fast->set_source(source.source(0.0315));
        reference->set_source(source.source(0.0315));
        for (const Pose& pose : moved_eyes) {
            const Eye eye(everything, pose);
            EyePicture a, b;
            fast->reproject(eye.view(), a);
            reference->reproject(eye.view(), b);
            int different = 0;
            for (std::size_t i = 0; i < a.rgba.samples().size(); ++i)
                different += std::abs(a.rgba.samples()[i] - b.rgba.samples()[i]) > 1;
            int masks = 0;
            for (std::size_t i = 0; i < a.origin.samples().size(); ++i)
                masks += a.origin.samples()[i] != b.origin.samples()[i];
            // Decisions on the tolerance's very edge may fall either way in single precision.
            EXPECT_LE(different, 4 * 8) << evidence(a.rgb().view(), b.rgb().view());
            EXPECT_LE(masks, 8);
        }
    }
}

TEST(Surface, NonFiniteAndAbsurdDepthsStayWhereTheyAre) {
    Rendered source = render(room, smooth_colour, EquirectCamera{400, 200, {}}, Pose{});
    const Rendered clean = source;
    const float nan = std::nanf("");
    for (const auto& [x, y, value] : {std::tuple{100, 100, nan},
                                      {101, 100, -1.0f},
                                      {200, 80, 0.0f},
                                      {203, 120, -float(infinity)},
                                      {300, 100, 1e-30f}})
        source.depth_m.pixel(x, y)[0] = value;
    Eye eye(room, Pose{{0.05, 0.02, 0}, yaw_pitch(0.1, 0)});
    eye.depth_m.pixel(20, 20)[0] = nan;
    eye.depth_m.pixel(40, 20)[0] = -2;
    eye.depth_m.pixel(60, 20)[0] = 0;
    for (const bool reference : {false, true}) {
        const auto engine = surface(reference);
        EyePicture damaged, whole;
        engine->set_source(clean.source());
        engine->reproject(Eye(room, eye.pose).view(), whole);
        engine->set_source(source.source());
        engine->reproject(eye.view(), damaged);
        EXPECT_EQ(damaged.origin.pixel(20, 20)[0], 0);
        EXPECT_EQ(damaged.origin.pixel(40, 20)[0], 0);
        EXPECT_EQ(damaged.origin.pixel(60, 20)[0], 0);
        EXPECT_LE(damaged.count(PixelOrigin::gap), 3 + 5);
        int changed = 0;
        for (std::size_t i = 0; i < whole.rgba.samples().size(); ++i)
            changed += whole.rgba.samples()[i] != damaged.rgba.samples()[i];
        EXPECT_LE(changed, 4 * (3 + 5 * 9)) << evidence(damaged.rgb().view(), whole.rgb().view());
    }
}

}  // namespace
}  // namespace equistream::test
