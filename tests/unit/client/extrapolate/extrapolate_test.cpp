// Pictures of a ball that moves and spins before a painted room, extrapolated and compared with those of the later
// time.
#include <tests/unit/client/moving_ball.h>

#include <client/extrapolate/extrapolate.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace equistream {
namespace {

using namespace test::moving_ball;

double psnr(double squares, std::int64_t count) {
    return 10 * std::log10(255 * 255 * 3 * double(count) / std::max(squares, 1e-9));
}
double squared_difference(const ByteImage& a, const ByteImage& b, int x, int y) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        sum += std::pow(double(a.pixel(x, y)[c]) - b.pixel(x, y)[c], 2);
    return sum;
}

struct Score {
    double carried_db = 0, held_db = 0;               ///< over pixels that show the ball then
    std::int64_t ball = 0, not_reached = 0;           ///< of them, without a surface or with the room's
    std::int64_t uncovered = 0, uncovered_wrong = 0;  ///< without a surface, and of them what still shows the ball
    std::int64_t changed_elsewhere = 0;               ///< outside the ball's pixels of both times, by more than nothing
    double worst_depth_share = 0;
};

Score score(const Scene& scene, double seconds) {
    const Picture before = look(scene, 0), after = look(scene, seconds);
    PictureExtrapolator extrapolator;
    ExtrapolatedPicture extrapolated;
    // Twice: what the first left in the carrier must not show.
    extrapolator.extrapolate(before.received, before.depth_m, 3 * seconds, extrapolated);
    extrapolator.extrapolate(before.received, before.depth_m, seconds, extrapolated);
    Score s;
    double carried_squares = 0, held_squares = 0;
    std::int64_t reached = 0;
    for (int y = 0; y < after.depth_m.height(); ++y)
        for (int x = 0; x < after.depth_m.width(); ++x) {
            const float r = *extrapolated.depth_m.pixel(x, y), truth_m = *after.depth_m.pixel(x, y);
            const bool is = *after.ball.pixel(x, y) != 0, was = *before.ball.pixel(x, y) != 0;
            if (std::isnan(r)) {
                ++s.uncovered;
                s.uncovered_wrong += is;
            }
            if (is) {
                ++s.ball;
                if (std::isnan(r) || r > truth_m * 1.2f) {
                    ++s.not_reached;
                    continue;
                }
                ++reached;
                carried_squares += squared_difference(extrapolated.picture.rgb, after.received.rgb, x, y);
                held_squares += squared_difference(before.received.rgb, after.received.rgb, x, y);
                s.worst_depth_share = std::max(s.worst_depth_share, std::abs(double(r) / truth_m - 1));
            } else if (!was) {
                s.changed_elsewhere +=
                    r != truth_m || squared_difference(extrapolated.picture.rgb, after.received.rgb, x, y) > 0;
            }
        }
    s.carried_db = psnr(carried_squares, reached);
    s.held_db = psnr(held_squares, reached);
    EXPECT_EQ(extrapolated.uncovered_pixels, s.uncovered);
    EXPECT_GE(extrapolated.moved_pixels, reached);
    return s;
}

/// A ball's outline may be off by a pixel of its circumference on either side; and what of it comes to be seen that was
/// not seen before, as it turns by so much against the line of sight, is not known.
void expect_extrapolated(const Score& s, double turned_rad) {
    EXPECT_GT(s.ball, 1000);
    EXPECT_GT(s.carried_db, 33);
    EXPECT_GT(s.carried_db, s.held_db + 15);
    const double outline = 4 * std::sqrt(double(s.ball));
    const double unseen = outline + 0.5 * (1 - std::cos(turned_rad)) * double(s.ball);
    EXPECT_LE(double(s.not_reached), unseen);
    EXPECT_LE(double(s.uncovered_wrong), unseen);
    EXPECT_LE(double(s.changed_elsewhere), outline);
    EXPECT_GT(s.uncovered, 100);
    EXPECT_LT(s.worst_depth_share, 0.1);
}

TEST(Extrapolate, WhatMovesIsWhereItIsThenAndItsOldPlaceIsEmpty) {
    expect_extrapolated(score({sphere, turned, {{0.3, 0.2, -1.9}, 0.5, {1.2, 0.4, -0.5}, {0.5, 2, -1}}}, 0.15), 0.45);
}

TEST(Extrapolate, AcrossTheSeam) {
    const glm::dvec3 behind = turned.position_m + turned.orientation * glm::dvec3(-0.1, 0.1, 1.8);
    expect_extrapolated(
        score({sphere, turned, {behind, 0.5, turned.orientation * glm::dvec3(1.5, 0, 0), {0, 1, 0}}}, 0.15), 0.3);
}

TEST(Extrapolate, OverThePole) {
    const glm::dvec3 above = turned.position_m + turned.orientation * glm::dvec3(-0.2, 1.8, 0.05);
    expect_extrapolated(score({sphere, turned, {above, 0.5, turned.orientation * glm::dvec3(2, 0, 0), {0, 1, 0}}}, 0.2),
                        0.42);
}

TEST(Extrapolate, ComingNearer) {
    expect_extrapolated(score({sphere, turned, {{0.3, 0.2, -2.9}, 0.5, {0.6, 0, 6}, {0, 2, 0}}}, 0.2), 0.5);
}

TEST(Extrapolate, InAFlatView) {
    const glm::dvec3 ahead = turned.position_m + turned.orientation * glm::dvec3(-0.3, 0.1, -2);
    expect_extrapolated(score({PerspectiveCamera{480, 360, 1.4},
                               turned,
                               {ahead, 0.5, turned.orientation * glm::dvec3(2, 0.3, 0.4), {0, 1, 0}}},
                              0.15),
                        0.3);
}

TEST(Extrapolate, BehindWhatStandsBeforeIt) {
    const glm::dvec3 ahead = turned.position_m + turned.orientation * glm::dvec3(-0.4, 0.1, -2);
    const Scene scene{sphere, turned, {ahead, 0.5, turned.orientation * glm::dvec3(3, 0, 0), {0, 0, 0}}, {0.0, 0.15}};
    const Score s = score(scene, 0.15);
    EXPECT_GT(s.carried_db, 38);
    // What was behind the post before is not known: it is as wide as that at most.
    EXPECT_LT(double(s.not_reached), 0.4 * double(s.ball));
    EXPECT_LE(double(s.changed_elsewhere), 4 * std::sqrt(double(s.ball)));
}

/// The ball is a mirror in which everything is 2 m behind its surface.
TEST(Extrapolate, ImagesInAMirrorStayAsFarBehindIt) {
    Picture made = look({sphere, turned, {{0.3, 0.2, -1.9}, 0.5, {0, 0, 3}}}, 0);
    made.received.specular = made.received.virtual_depth_m = FloatImage(768, 384, 1);
    for (std::size_t i = 0; i < made.ball.samples().size(); ++i) {
        made.received.specular.samples()[i] = made.ball.samples()[i] != 0 ? 1 : 0;
        made.received.virtual_depth_m.samples()[i] = made.depth_m.samples()[i] + 2;
    }
    ExtrapolatedPicture later;
    PictureExtrapolator().extrapolate(made.received, made.depth_m, 0.1, later);
    EXPECT_GT(later.moved_pixels, 1000);
    for (std::size_t i = 0; i < later.depth_m.samples().size(); ++i)
        if (const float r = later.depth_m.samples()[i]; !std::isnan(r)) {
            ASSERT_NEAR(later.picture.virtual_depth_m.samples()[i] - r, 2, 1e-4);
        }
}

TEST(Extrapolate, ColoursAreMixedOfPixelsThatThereAre) {
    const MovingRegion region;
    FrameInfo whole, flat;
    whole.camera = EquirectCamera{16, 8, {}};
    flat.camera = PerspectiveCamera{16, 8, 1};
    for (const FrameInfo& info : {whole, flat}) {
        const bool is_whole = std::holds_alternative<EquirectCamera>(info.camera);
        const MovedRegion moved(region, info, 0.1);
        for (const double y : {0.0, 0.25, 4.5, 7.75, 7.999})
            for (const double x : {0.0, 0.25, 8.5, 15.75, 15.999}) {
                double weights = 0;
                for (const MovedRegion::Tap& tap : moved.taps({x, y})) {
                    EXPECT_TRUE(tap.x >= 0 && tap.x < 16 && tap.y >= 0 && tap.y < 8) << x << ", " << y;
                    const double aside = std::abs(tap.x + 0.5 - x), near = std::min(aside, 16 - aside);
                    EXPECT_LE(is_whole ? near : aside, 1) << x;
                    EXPECT_LE(std::abs(tap.y + 0.5 - y), 1) << y;
                    weights += tap.weight;
                }
                EXPECT_NEAR(weights, 1, 1e-12);
            }
    }
}

TEST(Extrapolate, NothingIsDoneWhereNothingMovesOrNoTimePasses) {
    Picture picture = look({sphere, turned, {{0.3, 0.2, -1.9}}}, 0);
    EXPECT_TRUE(can_extrapolate(picture.received, 0.1));
    EXPECT_FALSE(can_extrapolate(picture.received, 0));
    EXPECT_FALSE(can_extrapolate(picture.received, -0.1));
    picture.received.info.moving.clear();
    EXPECT_FALSE(can_extrapolate(picture.received, 0.1));
}

TEST(Extrapolate, MotionOfAnySizeIsSurvived) {
    PictureExtrapolator extrapolator;
    ExtrapolatedPicture extrapolated;
    for (const Camera& camera : {Camera(EquirectCamera{96, 48, {}}), Camera(PerspectiveCamera{96, 72, 1.4})})
        for (const double v : {1e3, 1e12, 3e38})
            for (const double w : {0.0, 1e3, 3e38}) {
                Picture picture = look({camera, {}, {{0, 0, -2}}}, 0);
                picture.received.info.moving[0].motion = {{{v, -v, v / 3}, {w, w / 2, -w}}, {{-v, 0, 0}, {0, w, 0}}};
                extrapolator.extrapolate(picture.received, picture.depth_m, 0.2, extrapolated);
                EXPECT_LE(extrapolated.moved_pixels + extrapolated.uncovered_pixels, 96 * 72);
                EXPECT_GT(extrapolated.moved_pixels + extrapolated.uncovered_pixels, 0);
            }
}

TEST(Extrapolate, ADecodersPlanesGiveWhatTheirColoursGive) {
    const Scene scene{sphere, turned, {{0.3, 0.2, -1.9}, 0.5, {1.2, 0.4, -0.5}, {0.5, 2, -1}}};
    Picture coloured = look(scene, 0);
    ByteImage y(768, 384, 1), cb(384, 192, 1), cr(384, 192, 1);
    std::srand(4);
    for (ByteImage* plane : {&y, &cb, &cr})
        for (std::uint8_t& sample : plane->samples())
            sample = std::uint8_t(16 + std::rand() % 220);
    const YuvView planes{y.view(), cb.view(), cr.view()};
    for (int row = 0; row < 384; ++row)
        for (int x = 0; x < 768; ++x)
            std::ranges::copy(yuv_to_rgb::rgb_at(planes, x, row), coloured.received.rgb.pixel(x, row));
    ReceivedPicture decoded;
    decoded.info = coloured.received.info;
    decoded.yuv.planes = planes;
    PictureExtrapolator extrapolator;
    ExtrapolatedPicture a, b;
    extrapolator.extrapolate(coloured.received, coloured.depth_m, 0.1, a);
    extrapolator.extrapolate(decoded, coloured.depth_m, 0.1, b);
    EXPECT_TRUE(std::ranges::equal(a.picture.rgb.samples(), b.picture.rgb.samples()));
}

}  // namespace
}  // namespace equistream
