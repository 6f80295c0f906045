/// The loops of every instruction set that this processor has, the scalar ones included, against the plain reference.
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/simd_targets.h>
#include <tests/unit/evidence.h>

#include <tests/support/references/plain_engines.h>

#include <client/warp/resample.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

namespace equistream::test {
namespace {

using glm::dvec3;

enum class Samples { rgb, rgba, planes };
constexpr std::array sample_names = {"rgb", "rgba", "planes"};

/// One picture as each kind of samples.
class Picture {
public:
    explicit Picture(const ByteImage& rgb) : rgb_(rgb), rgba_(rgb.width(), rgb.height(), 4, 77) {
        for (int y = 0; y < rgb.height(); ++y)
            for (int x = 0; x < rgb.width(); ++x)
                std::copy_n(rgb.pixel(x, y), 3, rgba_.pixel(x, y));
        y_ = ByteImage(rgb.width(), rgb.height(), 1);
        // Rows of different strides, as decoders may have them.
        cb_ = ByteImage(rgb.width() / 2 + 3, rgb.height() / 2, 1);
        cr_ = ByteImage(rgb.width() / 2 + 8, rgb.height() / 2, 1);
        rgb_to_yuv420(rgb_.view(), {y_.view(), narrowed(cb_.view()), narrowed(cr_.view())});
    }
    void show(SourceView& source, Samples samples) const {
        source.rgb = {};
        source.yuv = {};
        if (samples == Samples::rgb)
            source.rgb = rgb_.view();
        else if (samples == Samples::rgba)
            source.rgb = rgba_.view();
        else
            source.yuv = {y_.view(), narrowed(cb_.view()), narrowed(cr_.view())};
    }

private:
    template <typename T>
    ImageView<T> narrowed(ImageView<T> plane) const {
        plane.width = rgb_.width() / 2;
        return plane;
    }

    ByteImage rgb_, rgba_, y_, cb_, cr_;
};

/// How far one picture is from another where both have a colour.
struct Agreement {
    double psnr_db = 0;
    int worst = 0;          ///< steps of 8 bits
    double gaps_apart = 0;  ///< share of pixels that are a gap of one only
};

Agreement agreement(const EyePicture& a, const EyePicture& b) {
    double squares = 0;
    std::int64_t both = 0, apart = 0;
    Agreement result;
    for (std::size_t i = 0; i < a.origin.samples().size(); ++i) {
        const bool in_a = a.origin.samples()[i] != 0, in_b = b.origin.samples()[i] != 0;
        apart += in_a != in_b;
        both += in_a && in_b;
        for (std::size_t c = 0; in_a && in_b && c < 3; ++c) {
            const int difference = std::abs(a.rgba.samples()[4 * i + c] - b.rgba.samples()[4 * i + c]);
            result.worst = std::max(result.worst, difference);
            squares += difference * difference;
        }
    }
    result.psnr_db = squares == 0 ? infinity : 10 * std::log10(255.0 * 255 * 3 * double(both) / squares);
    result.gaps_apart = double(apart) / double(a.origin.samples().size());
    return result;
}

EyePicture made(std::unique_ptr<Engine> engine, const SourceView& source, const EyeView& eye) {
    engine->set_source(source);
    EyePicture picture;
    engine->reproject(eye, picture);
    return picture;
}

EyePicture made_by(std::int64_t target, const char* engine_name, const SourceView& source, const EyeView& eye) {
    const OnlyTarget only(target);
    return made(make_engine(engine_name), source, eye);
}

class EveryTarget : public testing::TestWithParam<std::tuple<std::int64_t, Samples>> {
protected:
    Samples samples() const { return std::get<1>(GetParam()); }
    EyePicture fast(const char* engine_name, const SourceView& source, const EyeView& eye) const {
        return made_by(std::get<0>(GetParam()), engine_name, source, eye);
    }
    static EyePicture slow(const char* engine_name, const SourceView& source, const EyeView& eye) {
        return made(plain::make_engine(engine_name), source, eye);
    }
};

INSTANTIATE_TEST_SUITE_P(Warp, EveryTarget,
                         testing::Combine(testing::ValuesIn(targets_here()),
                                          testing::Values(Samples::rgb, Samples::rgba, Samples::planes)),
                         [](const auto& test) {
                             return std::string(hwy::TargetName(std::get<0>(test.param))) + "_" +
                                    sample_names[std::size_t(std::get<1>(test.param))];
                         });

/// Where the test itself says which samples.
class EachTarget : public testing::TestWithParam<std::int64_t> {};

INSTANTIATE_TEST_SUITE_P(Warp, EachTarget, testing::ValuesIn(targets_here()),
                         [](const auto& test) { return std::string(hwy::TargetName(test.param)); });

/// Every column or every row black or white in turn: 1/32 of a sample across them shows as 8.
ByteImage stripes(int width, int height, bool columns) {
    ByteImage picture(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            std::fill_n(picture.pixel(x, y), 3, std::uint8_t((columns ? x : y) % 2 == 0 ? 0 : 255));
    return picture;
}

const std::vector<std::pair<double, double>> directions = {{0, 0},       {pi, 0},   {pi - 0.3, 0.4}, {0.3, pi / 2},
                                                           {2, -pi / 2}, {-1, 1.3}, {2.7, -0.6}};

/// Of a sphere that is denser than the eye's view, and of others: anywhere, seam and poles included.
TEST_P(EveryTarget, PositionsAreGoodToAThirtySecondOfASample) {
    for (const Camera& camera :
         {Camera(EquirectCamera{1920, 960, {}}), Camera(EquirectCamera{400, 180, {-1, 1.5, -0.7, 0.8}}),
          Camera(PerspectiveCamera{640, 400, 1.9})})
        for (const bool columns : {true, false}) {
            const Picture picture(stripes(width_of(camera), height_of(camera), columns));
            SourceView source{.camera = camera, .pose = {{}, yaw_pitch(0.1, 0.05)}};
            picture.show(source, samples());
            for (const auto& [yaw, pitch] : directions) {
                const EyeView eye{{211, 123, 0.6}, {{}, yaw_pitch(yaw, pitch)}};
                const EyePicture a = fast("sphere", source, eye), b = slow("sphere", source, eye);
                // Weights are in 128ths too, each off by up to half a step.
                EXPECT_LE(agreement(a, b).worst, 255 / 32 + 255 / 128 + 1) << evidence(a.rgb().view(), b.rgb().view());
                EXPECT_LE(agreement(a, b).gaps_apart, 1e-4);
            }
        }
}

TEST_P(EveryTarget, TurnedNoiseIsAtLeast50DecibelsFromTheReference) {
    std::mt19937 random(5);
    ByteImage noise(512, 256, 3);
    for (std::uint8_t& sample : noise.samples())
        sample = std::uint8_t(16 + random() % 224);
    const Picture picture(noise);
    SourceView source{.camera = EquirectCamera{512, 256, {}}};
    picture.show(source, samples());
    for (const auto& [yaw, pitch] : directions) {
        const EyeView eye{{200, 120, pi / 2}, {{}, yaw_pitch(yaw, pitch)}};
        const EyePicture a = fast("sphere", source, eye), b = slow("sphere", source, eye);
        EXPECT_GE(agreement(a, b).psnr_db, 50) << evidence(a.rgb().view(), b.rgb().view());
        EXPECT_EQ(agreement(a, b).gaps_apart, 0);
    }
}

/// A floor, a tilted wall, a ball before them and the sky.
double scene(const dvec3& o, const dvec3& d) {
    return std::min({to_sphere(o, d, {0.1, 0, -1.5}, 0.4), to_plane(o, d, {0, 1, 0}, -1.6),
                     to_plane(o, d, {0.5, 0, std::sqrt(0.75)}, -4 * std::sqrt(0.75))});
}

TEST_P(EveryTarget, SurfacesAndGapsAreTheReferences) {
    for (const Camera& camera : {Camera(EquirectCamera{1280, 640, {}}), Camera(PerspectiveCamera{640, 480, 2})}) {
        const Rendered rendered = render(
            scene, [](const dvec3& p, double) { return smooth(p, 6); }, camera, Pose{{0.1, 0, 0}, yaw_pitch(0.2, 0.1)});
        const Picture picture(rendered.rgb);
        SourceView source = rendered.source(0.0315);
        picture.show(source, samples());
        std::int64_t gaps = 0;
        for (const Pose& pose :
             {Pose{{0.13, 0, 0}, yaw_pitch(0.2, 0)}, Pose{{-0.05, 0.1, -0.05}, yaw_pitch(-0.3, -0.4)},
              Pose{{0.1, -0.1, 0.2}, yaw_pitch(pi, 0.3)}, Pose{{0.1, 0.05, 0}, yaw_pitch(1, -1.5)}}) {
            const PerspectiveCamera eye_camera{331, 187, pi / 2};
            FloatImage depth_m(eye_camera.width, eye_camera.height, 1);
            AnalyticDepth(scene).cast(eye_camera, pose, depth_m.view());
            const EyeView eye{eye_camera, pose, depth_m.view()};
            const EyePicture a = fast("surface", source, eye), b = slow("surface", source, eye);
            // Decisions on the tolerance's very edge may fall either way.
            EXPECT_LE(agreement(a, b).gaps_apart, 2e-4) << evidence(a.rgb().view(), b.rgb().view());
            EXPECT_GE(agreement(a, b).psnr_db, 50) << evidence(a.rgb().view(), b.rgb().view());
            gaps += b.count(PixelOrigin::gap);
        }
        EXPECT_GT(gaps, 300);
    }
}

/// Planes are turned into RGB by the same integers wherever that is done, and weights do not depend on the samples: a
/// picture looked up in planes is that looked up in their RGB, with nothing left to rounding.
TEST_P(EachTarget, PlanesGiveThePictureOfTheirRgb) {
    std::mt19937 random(11);
    for (const auto& [width, height] : {std::pair{768, 384}, {64, 32}, {38, 18}, {10, 6}}) {
        ByteImage y(width, height, 1), cb(width / 2, height / 2, 1), cr(width / 2, height / 2, 1);
        for (ByteImage* plane : {&y, &cb, &cr})
            for (std::uint8_t& sample : plane->samples())
                sample = std::uint8_t(random());
        ByteImage rgb(width, height, 3);
        yuv420_to_rgb({y.view(), cb.view(), cr.view()}, rgb.view());
        FloatImage depth_m(width, height, 1);
        const EquirectCamera camera{width, height, {}};
        AnalyticDepth(scene).cast(camera, Pose{}, depth_m.view());
        SourceView in_rgb{.rgb = rgb.view(), .camera = camera, .depth_m = depth_m.view(), .box_radius_m = 0.1};
        SourceView in_planes = in_rgb;
        in_planes.rgb = {};
        in_planes.yuv = {y.view(), cb.view(), cr.view()};
        for (const double fov : {0.3, pi / 2, 2.6})  // the eye magnifies the sphere, and the other way round
            for (const auto& [yaw, pitch] : directions)
                for (const char* engine : {"sphere", "surface"}) {
                    const EyeView turned{{211, 123, fov}, {{0.05, 0.02, 0}, yaw_pitch(yaw, pitch)}};
                    FloatImage eye_depth_m(211, 123, 1);
                    AnalyticDepth(scene).cast(turned.camera, turned.pose, eye_depth_m.view());
                    const EyeView eye{turned.camera, turned.pose, eye_depth_m.view()};
                    const EyePicture a = made_by(GetParam(), engine, in_planes, eye),
                                     b = made_by(GetParam(), engine, in_rgb, eye);
                    ASSERT_EQ(agreement(a, b).worst, 0) << engine << " " << width << " " << fov << " " << yaw << " "
                                                        << evidence(a.rgb().view(), b.rgb().view());
                    ASSERT_TRUE(std::ranges::equal(a.origin.samples(), b.origin.samples()));
                }
    }
}

/// Sources smaller than what is read at once.
TEST_P(EveryTarget, SmallSourcesAreReadInside) {
    for (const auto& [width, height] : {std::pair{2, 2}, {4, 2}, {6, 4}, {10, 6}, {16, 8}}) {
        std::mt19937 random(9);
        ByteImage rgb(width, height, 3);
        for (std::uint8_t& sample : rgb.samples())
            sample = std::uint8_t(16 + random() % 224);
        const Picture picture(rgb);
        SourceView source{.camera = EquirectCamera{width, height, {}}};
        picture.show(source, samples());
        const EyeView eye{{37, 21, 1.2}, {{}, yaw_pitch(1, 0.7)}};
        const EyePicture a = fast("sphere", source, eye), b = slow("sphere", source, eye);
        EXPECT_LE(agreement(a, b).worst, 5) << width << "x" << height;
        EXPECT_EQ(agreement(a, b).gaps_apart, 0);
    }
}

TEST_P(EveryTarget, OnlyGapsAreColouredWhereSoAsked) {
    const Picture picture(stripes(64, 32, true));
    SourceView source{.camera = EquirectCamera{64, 32, {}}};
    picture.show(source, samples());
    const EyeView eye{{37, 21, 1.2}, {{}, yaw_pitch(1, 0.3)}, {}};
    EyePicture all, partly;
    all.reset(eye.camera);
    partly.reset(eye.camera);
    for (std::size_t i = 0; i < 37 * 21; i += 3) {
        partly.origin.samples()[i] = std::uint8_t(PixelOrigin::small);
        std::ranges::fill(partly.rgba.samples().subspan(4 * i, 4), std::uint8_t{9});
    }
    ResampleOptions options{.tolerance_rad = 1e-3, .mark = PixelOrigin::base};
    const OnlyTarget only(std::get<0>(GetParam()));
    EXPECT_EQ(resample_by_direction(source, eye, options, all), 37 * 21);
    options.only_gaps = true;
    EXPECT_EQ(resample_by_direction(source, eye, options, partly), 37 * 21 * 2 / 3);
    for (std::size_t i = 0; i < 37 * 21; ++i) {
        ASSERT_EQ(partly.origin.samples()[i], std::uint8_t(i % 3 == 0 ? PixelOrigin::small : PixelOrigin::base));
        for (std::size_t c = 0; c < 4; ++c)
            ASSERT_EQ(partly.rgba.samples()[4 * i + c], i % 3 == 0 ? 9 : all.rgba.samples()[4 * i + c]);
    }
}

}  // namespace
}  // namespace equistream::test
