#include "analytic_scene.h"
#include "simd_targets.h"

#include <equistream_client/fill.h>
#include <equistream_client/reliability.h>

#include <gtest/gtest.h>

#include <random>

namespace equistream::test {
namespace {

using glm::dvec3;

double ball_and_wall(const dvec3& o, const dvec3& d) {
    return std::min(to_sphere(o, d, {0.1, 0, -1.5}, 0.4), to_plane(o, d, {0, 0, 1}, -4));
}

dvec3 smooth_colour(const dvec3& p, double) {
    return smooth(p, 1.5);
}

const PerspectiveCamera eye_camera{160, 100, pi / 2};
const Pose moved{{0.063, 0.02, 0}, {1, 0, 0, 0}};

/// A source, an eye and the picture of it.
struct Played {
    Rendered source;
    FloatImage depth_m;
    EyeView eye;
    EyePicture picture;

    Played(const Distance& distance, const Colour& colour, const Pose& pose, const std::string& method,
           const std::string& fill)
        : source(render(distance, colour, EquirectCamera{640, 320, {}}, Pose{})), depth_m(160, 100, 1) {
        AnalyticDepth(distance).cast(eye_camera, pose, depth_m.view());
        eye = {eye_camera, pose, method == "surface" ? depth_m.view() : ImageView<const float>{}};
        const SourceView view = source.source(0.063);
        const auto engine = make_engine(method);
        engine->set_source(view);
        engine->reproject(eye, picture);
        const FillLadder ladder = make_fill_ladder(fill);
        for (const auto& rung : ladder)
            rung->set_frame({.main = &view});
        fill_gaps(ladder, eye, picture);
    }
    SourceView view() const { return source.source(0.063); }
    FloatImage risks(const ReliabilityOptions& options = {}) const {
        return reliability_risks(view(), eye, picture, options);
    }
    double mean_where(PixelOrigin origin) const {
        double sum = 0, count = 0;
        for (std::size_t i = 0; i < picture.origin.samples().size(); ++i)
            if (picture.origin.samples()[i] == std::uint8_t(origin)) {
                sum += picture.reliability.samples()[i] / 255.0;
                ++count;
            }
        return count > 0 ? sum / count : -1;
    }
};

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
                    const float now = reliability_of(RiskGroup(group), risks);
                    ASSERT_LE(now, before) << risk_names[std::size_t(risk)] << " " << value;
                    ASSERT_TRUE(now >= 0 && now <= 1);
                    before = now;
                }
            }
}

TEST(Reliability, ThePlainMapIsTheModelOfTheRisks) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    estimate_reliability(played.view(), played.eye, played.picture, {.reference = true});
    const FloatImage risks = played.risks();
    const ByteImage groups = reliability_groups(played.view(), played.eye, played.picture);
    for (int y = 0; y < eye_camera.height; ++y)
        for (int x = 0; x < eye_camera.width; ++x) {
            std::array<float, risk_count> here;
            std::copy_n(risks.pixel(x, y), risk_count, here.begin());
            const auto origin = PixelOrigin(played.picture.origin.pixel(x, y)[0]);
            ASSERT_EQ(groups.pixel(x, y)[0], std::uint8_t(risk_group(origin, KnownDepth::fine)));
            ASSERT_NEAR(reliability_of(RiskGroup(groups.pixel(x, y)[0]), here) * 255,
                        float(played.picture.reliability.pixel(x, y)[0]), 0.01);
        }
}

/// How many pixels two maps of one picture differ in by more than the order of a sum explains, and by how much at most.
struct MapDifference {
    int pixels = 0, most = 0;
};
MapDifference difference(const ByteImage& a, const ByteImage& b) {
    MapDifference found;
    for (std::size_t i = 0; i < a.samples().size(); ++i) {
        const int off = std::abs(int(a.samples()[i]) - int(b.samples()[i]));
        found.pixels += off > 0;
        found.most = std::max(found.most, off);
    }
    return found;
}

/// Noise in every channel, so that no difference between neighbours is like another, and a mirror in a corner.
void expect_maps_of_all_targets_alike(Played& played, ReliabilityOptions options,
                                      const FloatImage* specular = nullptr) {
    SourceView view = played.view();
    if (specular != nullptr)
        view.specular = specular->view();
    std::mt19937 random(7);
    for (std::uint8_t& sample : played.picture.rgba.samples())
        sample = std::uint8_t(std::clamp<int>(sample + int(random() % 41) - 20, 0, 255));
    options.reference = true;
    estimate_reliability(view, played.eye, played.picture, options);
    const ByteImage plain = played.picture.reliability;
    const int pixels = int(plain.samples().size());
    options.reference = false;
    for (const std::int64_t target : targets_here()) {
        const OnlyTarget only(target);
        estimate_reliability(view, played.eye, played.picture, options);
        const MapDifference found = difference(plain, played.picture.reliability);
        // The order of a sum may put it on the other side of an entry of the table.
        EXPECT_LE(found.pixels, pixels / 500) << hwy::TargetName(target);
        EXPECT_LE(found.most, 24) << hwy::TargetName(target);
    }
}

TEST(Reliability, EveryInstructionSetMakesThePlainMap) {
    for (const char* fill : {"none", "pushpull", "spread"})
        for (const char* method : {"surface", "sphere", "splat"}) {
            SCOPED_TRACE(std::string(method) + " " + fill);
            Played played(ball_and_wall, smooth_colour, moved, method, fill);
            expect_maps_of_all_targets_alike(played, {.depth_tolerance_w = 0.01});
        }
    Played still(ball_and_wall, smooth_colour, Pose{}, "surface", "none");
    expect_maps_of_all_targets_alike(still, {});
}

TEST(Reliability, EveryInstructionSetFindsMirrors) {
    Played played(ball_and_wall, smooth_colour, moved, "surface", "pushpull");
    FloatImage specular(640, 320, 1);
    for (int y = 0; y < 320; ++y)
        for (int x = 0; x < 640; ++x)
            specular.pixel(x, y)[0] = (x / 7 + y / 5) % 2 == 0 ? 1.0f : 0.0f;
    expect_maps_of_all_targets_alike(played, {}, &specular);
}

/// Every kind of origin side by side, sizes that no vector divides, and more of them than a band of rows has.
TEST(Reliability, EveryInstructionSetTakesAnyOriginAndSize) {
    for (const auto& [width, height] : {std::pair{34, 7}, {61, 41}, {97, 70}, {20, 9}}) {
        const PerspectiveCamera camera{width, height, 1.2};
        EyePicture picture;
        picture.reset(camera);
        FloatImage depth_m(width, height, 1);
        std::mt19937 random(static_cast<unsigned>(width));
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                for (int c = 0; c < 4; ++c)
                    picture.rgba.pixel(x, y)[c] = std::uint8_t(random() % 256);
                picture.origin.pixel(x, y)[0] =
                    std::uint8_t(random() % 3 == 0 ? random() % unsigned(pixel_origin_count) : 1);
                depth_m.pixel(x, y)[0] = random() % 9 == 0 ? float(infinity) : 1 + float(random() % 1000) / 500;
            }
        const Rendered source = render(ball_and_wall, smooth_colour, EquirectCamera{64, 32, {}}, Pose{});
        const EyeView eye{camera, moved, depth_m.view()};
        const SourceView view = source.source(0.063);
        estimate_reliability(view, eye, picture, {.reference = true});
        const ByteImage plain = picture.reliability;
        for (const std::int64_t target : targets_here()) {
            const OnlyTarget only(target);
            estimate_reliability(view, eye, picture);
            const MapDifference found = difference(plain, picture.reliability);
            EXPECT_LE(found.pixels, 1 + width * height / 500)
                << hwy::TargetName(target) << " " << width << "x" << height;
            EXPECT_LE(found.most, 24) << hwy::TargetName(target) << " " << width << "x" << height;
        }
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

}  // namespace
}  // namespace equistream::test
