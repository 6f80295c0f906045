#include <tests/unit/client/reliability_scene.h>

#include <equistream/error.h>

#include <tests/support/references/plain_engines.h>

#include <equistream/bound.h>
#include <gtest/gtest.h>

namespace equistream::test {
namespace {

float risk_at(const FloatImage& risks, Risk risk, int x, int y) {
    return risks.pixel(x, y)[int(risk)];
}

TEST(Reliability, TheSourcesVeryViewIsCertain) {
    const Rendered source = render(ball_and_wall, smooth_colour, eye_camera, moved);
    const EyeView eye{eye_camera, moved, {}};
    EyePicture picture;
    const auto engine = make_engine("surface");
    engine->set_source(source.source());
    engine->reproject(eye, picture);
    estimate_reliability(source.source(), eye, picture);
    for (const std::uint8_t value : picture.reliability.samples())
        ASSERT_EQ(value, 255);
    VisibleLoss loss;
    loss.share_255.fill(51);
    estimate_reliability(source.source(), eye, picture, {.visible_loss = loss});
    for (const std::uint8_t value : picture.reliability.samples())
        ASSERT_EQ(value, 192) << "how noisy it is counts all the same: 255 * 0.8 * 0.94";
}

TEST(Reliability, RotationAloneOfSmoothColoursIsNearlyCertain) {
    Played played(ball_and_wall, smooth_colour, Pose{}, "surface", "none");
    estimate_reliability(played.view(), played.eye, played.picture);
    EXPECT_GT(played.mean_where(PixelOrigin::source), 0.95);
}

TEST(Reliability, WhatWasFilledInIsTrustedLessAndWhatIsOpenNotAtAll) {
    Played filled(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    estimate_reliability(filled.view(), filled.eye, filled.picture);
    ASSERT_GT(filled.picture.count(PixelOrigin::push_pull), 50);
    EXPECT_LT(filled.mean_where(PixelOrigin::push_pull), filled.mean_where(PixelOrigin::source) - 0.1);

    Played open(ball_and_wall, smooth_colour, moved, "surface", "none");
    estimate_reliability(open.view(), open.eye, open.picture);
    ASSERT_GT(open.picture.count(PixelOrigin::gap), 50);
    EXPECT_EQ(open.mean_where(PixelOrigin::gap), 0);
}

TEST(Reliability, TurningWhereTheEyeHasMovedIsTrustedLess) {
    const Colour stripes = [](const dvec3& p, double) {
        return dvec3(std::fmod(std::abs(p.x) * 8, 1.0) < 0.5 ? 0.2 : 0.8);
    };
    Played turned(ball_and_wall, stripes, moved, "sphere", "none");
    Played warped(ball_and_wall, stripes, moved, "surface", "none");
    estimate_reliability(turned.view(), turned.eye, turned.picture);
    estimate_reliability(warped.view(), warped.eye, warped.picture);
    EXPECT_LT(turned.mean_where(PixelOrigin::source), warped.mean_where(PixelOrigin::source));
}

TEST(Reliability, NoRiskMakesAPixelMoreTrustworthy) {
    for (int group = 0; group < risk_group_count; ++group)
        for (int risk = 0; risk < risk_count; ++risk)
            for (const float others : {0.0f, 0.5f, 1.0f, 3.0f}) {
                std::array<float, risk_count> risks;
                risks.fill(others);
                float before = 2;
                for (float value = 0; value < 12; value += 0.125f) {
                    risks[std::size_t(risk)] = value;
                    const float now = plain::reliability_of(RiskGroup(group), risks);
                    ASSERT_LE(now, before) << risk_names[std::size_t(risk)] << " " << value;
                    ASSERT_TRUE(now >= 0 && now <= 1);
                    before = now;
                }
            }
}

TEST(Reliability, ThePlainMapIsTheModelOfTheRisks) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    plain::estimate_reliability(played.view(), played.eye, played.picture);
    const FloatImage risks = plain::reliability_risks(played.view(), played.eye, played.picture);
    const ByteImage groups = plain::reliability_groups(played.view(), played.eye, played.picture);
    for (int y = 0; y < eye_camera.height; ++y)
        for (int x = 0; x < eye_camera.width; ++x) {
            std::array<float, risk_count> here;
            std::copy_n(risks.pixel(x, y), risk_count, here.begin());
            const auto origin = PixelOrigin(played.picture.origin.pixel(x, y)[0]);
            ASSERT_EQ(groups.pixel(x, y)[0], std::uint8_t(risk_group(origin, KnownDepth::fine)));
            ASSERT_NEAR(plain::reliability_of(RiskGroup(groups.pixel(x, y)[0]), here) * 255,
                        float(played.picture.reliability.pixel(x, y)[0]), 0.01);
        }
}

/// A floor 1.6 m down: cosine, parallax and density in closed form.
TEST(Reliability, RisksOfAPlaneAreThoseOfItsGeometry) {
    const Distance floor = [](const dvec3& o, const dvec3& d) { return to_plane(o, d, {0, 1, 0}, -1.6); };
    const Colour fine = [](const dvec3& p, double) { return smooth(p, 12); };
    Played played(floor, fine, moved, "surface", "none");
    const FloatImage risks = played.risks();
    const double focal = eye_camera.focal_px();
    const double density = 320 / pi;
    for (const auto& [x, y] : {std::pair{20, 80}, {80, 70}, {140, 95}, {60, 60}}) {
        const dvec3 d = eye_camera.direction(x + 0.5, y + 0.5);
        const double r = played.depth_m.pixel(x, y)[0];
        const dvec3 point = moved.position_m + r * d;
        const double detail = risk_at(risks, Risk::detail, x, y);
        ASSERT_GT(detail, 0.1);
        EXPECT_NEAR(risk_at(risks, Risk::parallax, x, y), std::log2(1 + focal * glm::length(moved.position_m) / r),
                    0.02);
        const double cosine = std::abs(d.y), cosine_source = std::abs(point.y) / glm::length(point);
        EXPECT_NEAR(risk_at(risks, Risk::grazing, x, y), detail * std::min(4.0, -std::log2(cosine)), 0.03 * detail);
        // Solid angles: of the eye's pixel -d.z^3 / f^2, of the source's 1 / density^2.
        const double source_pixels = std::pow(density * r / glm::length(point), 2) * cosine_source / cosine *
                                     std::pow(-d.z, 3) / (focal * focal);
        const double doublings = 0.5 * std::log2(source_pixels);
        const double closer = -std::log2(std::sqrt(1 - std::pow(point.y / glm::length(point), 2)));
        EXPECT_NEAR(risk_at(risks, Risk::blur, x, y),
                    0.5 * detail * (std::max(0.0, -doublings) + std::max(0.0, -doublings - closer)), 0.03 * detail);
        EXPECT_NEAR(risk_at(risks, Risk::minification, x, y), detail * std::max(0.0, doublings), 0.03 * detail);
    }
}

TEST(Reliability, SilhouettesAreFoundAndNothingElse) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    const FloatImage risks = played.risks();
    int wrong = 0, edges = 0;
    for (int y = 4; y < eye_camera.height - 4; ++y)
        for (int x = 4; x < eye_camera.width - 4; ++x) {
            // Ball and wall differ by more than a metre; the ball's own rim slopes ever more steeply.
            bool step = false, origins = false;
            for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
                step |= std::abs(played.depth_m.pixel(x + dx, y + dy)[0] - played.depth_m.pixel(x, y)[0]) > 1;
                origins |= played.picture.origin.pixel(x + dx, y + dy)[0] != played.picture.origin.pixel(x, y)[0];
            }
            edges += step || origins;
            if (step || origins)
                wrong += risk_at(risks, Risk::silhouette_0, x, y) != 1;
            if (risk_at(risks, Risk::silhouette_0, x, y) == 1) {
                ASSERT_EQ(risk_at(risks, Risk::silhouette_2, x - 2, y + 1), 1);
                ASSERT_EQ(risk_at(risks, Risk::silhouette_1, x + 1, y - 1), 1);
            }
        }
    ASSERT_GT(edges, 50);
    EXPECT_LE(wrong, edges / 20);
    const Distance wall = [](const dvec3& o, const dvec3& d) { return to_plane(o, d, {0.6, 0.1, 0.8}, -2); };
    const FloatImage plain = Played(wall, smooth_colour, moved, "surface", "none").risks();
    for (int y = 0; y < eye_camera.height; ++y)
        for (int x = 0; x < eye_camera.width; ++x)
            ASSERT_EQ(risk_at(plain, Risk::silhouette_2, x, y), 0) << x << " " << y;
}

TEST(Reliability, DepthErrorAndMirrorsCount) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    const FloatImage exact = played.risks(), coarse = played.risks({.depth_tolerance_w = 0.02});
    EXPECT_EQ(risk_at(exact, Risk::depth_error, 40, 50), 0);
    EXPECT_GT(risk_at(coarse, Risk::depth_error, 40, 50), 0);
    FloatImage specular(640, 320, 1);
    std::ranges::fill(specular.samples(), 1.0f);
    SourceView view = played.view();
    view.specular = specular.view();
    const FloatImage mirrors = reliability_risks(view, played.eye, played.picture);
    EXPECT_EQ(risk_at(exact, Risk::specular, 40, 50), 0);
    EXPECT_EQ(risk_at(mirrors, Risk::specular, 40, 50), risk_at(exact, Risk::contrast, 40, 50));
    const auto group_of = [&](const ReliabilityOptions& options) {
        return RiskGroup(reliability_groups(view, played.eye, played.picture, options).pixel(40, 50)[0]);
    };
    EXPECT_EQ(group_of({}), RiskGroup::mirrored);
    EXPECT_EQ(group_of({.specular_reworked = true}), RiskGroup::source);
    view.specular = {};
    EXPECT_EQ(group_of({}), RiskGroup::source);
    EXPECT_EQ(group_of({.depth_tolerance_w = 0.02}), RiskGroup::coarse);
}

/// A pixel is good where neither geometry nor the source's light is off: shares of the two are multiplied.
TEST(Reliability, LossCountsWhereThereIsSuchTexture) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    std::ranges::fill(played.picture.rgba.samples().subspan(0, 160 * 4 * 40), std::uint8_t{90});
    const FloatImage risks = played.risks();
    const VisibleLoss loss{{40, 4, 8, 12, 16, 20, 60, 200}};  // most where nothing is left
    estimate_reliability(played.view(), played.eye, played.picture);
    const ByteImage whole = played.picture.reliability;
    estimate_reliability(played.view(), played.eye, played.picture, {.visible_loss = loss});
    for (int y = 0; y < eye_camera.height; ++y)
        for (int x = 0; x < eye_camera.width; ++x) {
            const double lost = loss_at(loss, float(risk_at(risks, Risk::texture, x, y)));
            ASSERT_NEAR(*played.picture.reliability.pixel(x, y), *whole.pixel(x, y) * (1 - lost) * (1 - 0.3 * lost),
                        0.51);
        }
    const double flat = 40 / 255.0;
    EXPECT_NEAR(*played.picture.reliability.pixel(80, 20), *whole.pixel(80, 20) * (1 - flat) * (1 - 0.3 * flat), 0.51);
}

TEST(Reliability, BrokenDepthGivesNumbersAllTheSame) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    const float broken[] = {std::nanf(""), -1.0f, 0.0f, 1e-30f, float(infinity), -float(infinity), 3e38f};
    for (int i = 0; i < 7; ++i)
        played.depth_m.pixel(20 + 10 * i, 50)[0] = broken[i];
    estimate_reliability(played.view(), played.eye, played.picture);
    const FloatImage risks = played.risks();
    for (const float risk : risks.samples())
        ASSERT_TRUE(std::isfinite(risk) && risk >= 0) << risk;
}

/// The message of the InputError that these views are refused with.
std::string refusal(const SourceView& source, const EyeView& eye, EyePicture picture) {
    try {
        estimate_reliability(source, eye, picture);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

/// Masks and depth are looked up by index: one of another size would be read beyond its end.
TEST(Reliability, PlanesOfOtherSizesAreRefused) {
    const Played played(ball_and_wall, smooth_colour, moved, "surface", "none");
    EXPECT_EQ(refusal(played.view(), played.eye, played.picture), "");
    const FloatImage less(640, 319, 1), more(161, 100, 1), channels(640, 320, 3);

    SourceView source = played.view();
    source.specular = less.view();
    EXPECT_EQ(refusal(source, played.eye, played.picture),
              "reliability: specular mask: expected 640x320 of 1 channel, found 640x319 of 1");
    source.specular = channels.view();
    EXPECT_EQ(refusal(source, played.eye, played.picture),
              "reliability: specular mask: expected 640x320 of 1 channel, found 640x320 of 3");

    EyeView eye = played.eye;
    eye.depth_m = more.view();
    EXPECT_EQ(refusal(played.view(), eye, played.picture),
              "reliability: depth of the eye: expected 160x100 of 1 channel, found 161x100 of 1");
    eye.depth_m = {};
    EyePicture picture = played.picture;
    picture.depth_m = more;
    EXPECT_EQ(refusal(played.view(), eye, picture),
              "reliability: depth of the eye: expected 160x100 of 1 channel, found 161x100 of 1");

    picture = played.picture;
    picture.origin = ByteImage(160, 99, 1);
    EXPECT_EQ(refusal(played.view(), played.eye, picture),
              "reliability: origins: expected 160x100 of 1 channel, found 160x99 of 1");
    picture = played.picture;
    picture.rgba = ByteImage(160, 100, 3);
    EXPECT_EQ(refusal(played.view(), played.eye, picture),
              "reliability: colours: expected 160x100 of 4 channels, found 160x100 of 3");
}

/// 80 columns or so of an eye's texture reach over four of the sphere's.
TEST(Reliability, NumbersOfAPictureAreThoseOfItsGeometry) {
    const SourceView coarse{.camera = EquirectCamera{128, 64, {}}, .box_radius_m = 0.063};
    const RiskNumbers n(coarse, {eye_camera, moved, {}}, true, {.depth_tolerance_w = 0.02});
    const double away_m = glm::length(moved.position_m), focal = eye_camera.focal_px();
    EXPECT_EQ(n.step, 4);
    EXPECT_EQ(n.texture_reach, 16);
    EXPECT_NEAR(n.outside, away_m / 0.063 - 1, 1e-5);
    EXPECT_NEAR(n.depth_error_px, 0.02 * away_m / 0.063 * focal, 1e-4);
    EXPECT_NEAR(n.min_step_inverse_m, error_budget_rad(focal) / away_m, 1e-6);
    EXPECT_NEAR(glm::distance(n.pole, glm::vec3(0, 1, 0)), 0, 1e-6);
    const SourceView flat{.camera = PerspectiveCamera{128, 64, 1}, .box_radius_m = 0.063};
    EXPECT_EQ(RiskNumbers(flat, {eye_camera, moved, {}}, true, {}).pole, glm::vec3(0)) << "no columns that converge";
}

}  // namespace
}  // namespace equistream::test
