// The denoiser around Open Image Denoise: seam, poles, blocks, bad samples. Skipped where the library is not there.
#include <plugin/denoise/denoiser.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <random>

namespace equistream {
namespace {

/// Smooth on the sphere, its poles included, with an edge at the middle of the back, where the seam is.
float truth(const glm::dvec3& direction) {
    const double bands = 0.5 + 0.3 * std::sin(6 * direction.y) + 0.15 * direction.x;
    return static_cast<float>(direction.z > 0.9 ? 0.6 * bands : bands);
}

class DenoiserTest : public ::testing::Test {
protected:
    void SetUp() override {
        try {
            denoiser.emplace(DenoiseQuality::balanced, 2);
        } catch (const InputError& missing) {
            GTEST_SKIP() << missing.what();
        }
    }

    static FloatImage clean(const EquirectCamera& camera) {
        FloatImage image(camera.width, camera.height, 4);
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                std::fill_n(image.pixel(x, y), 3, truth(camera.direction(x + 0.5, y + 0.5)));
                image.pixel(x, y)[3] = 0.25f;
            }
        return image;
    }
    /// Exponentially distributed, as radiance of one sample often is: its deviation is its mean.
    static Frame noisy(const EquirectCamera& camera, unsigned seed = 1) {
        Frame frame;
        frame.info.camera = camera;
        FloatImage image = clean(camera);
        std::mt19937 random(seed);
        std::exponential_distribution<float> noise;
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                for (int c = 0; c < 3; ++c)
                    image.pixel(x, y)[c] *= noise(random);
        frame.planes["colour"] = std::move(image);
        return frame;
    }
    /// Mean square of what R is off.
    static double error(const FloatImage& image, const FloatImage& right) {
        double sum = 0;
        for (int y = 0; y < image.height(); ++y)
            for (int x = 0; x < image.width(); ++x)
                sum += std::pow(double{image.pixel(x, y)[0]} - right.pixel(x, y)[0], 2);
        return sum / image.width() / image.height();
    }

    std::optional<Denoiser> denoiser;
};

TEST_F(DenoiserTest, TakesMostOfTheNoiseAndLeavesAlpha) {
    const EquirectCamera camera{384, 192, {}};
    Frame frame = noisy(camera);
    const FloatImage right = clean(camera);
    const double before = error(frame.planes["colour"], right);
    denoiser->denoise(frame);
    EXPECT_LT(error(frame.planes["colour"], right), before / 50);
    EXPECT_EQ(frame.planes["colour"].pixel(7, 7)[3], 0.25f);
    EXPECT_NE(denoiser->description().find("Open Image Denoise 2."), std::string::npos);
}

// An edge of the truth lies near the seam, so that one without wrapping is off by much.
TEST_F(DenoiserTest, TheSeamIsNoPlaceOfItsOwn) {
    const EquirectCamera camera{384, 192, {}};
    double at_seam = 0, elsewhere = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
        Frame frame = noisy(camera, seed);
        denoiser->denoise(frame);
        const FloatImage& colour = frame.planes["colour"];
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const double step =
                    std::abs(double{colour.pixel((x + 1) % camera.width, y)[0]} - colour.pixel(x, y)[0]);
                if (x == camera.width - 1)
                    at_seam += step;
                else if (x < 8 || x >= camera.width - 9)
                    elsewhere += step / 16;
            }
    }
    EXPECT_LT(at_seam, 1.2 * elsewhere);
}

TEST_F(DenoiserTest, ASphereThatIsTurnedIsDenoisedAlike) {
    const EquirectCamera camera{384, 192, {}};
    Frame straight = noisy(camera), turned = noisy(camera);
    FloatImage& colour = turned.planes["colour"];
    const FloatImage& from = straight.planes["colour"];
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            std::copy_n(from.pixel((x + 192) % 384, y), 4, colour.pixel(x, y));
    denoiser->denoise(straight);
    denoiser->denoise(turned);
    double worst = 0;
    for (int y = 0; y < camera.height; ++y)
        for (int x = 0; x < camera.width; ++x)
            worst = std::max(worst, std::abs(double{colour.pixel(x, y)[0]} - from.pixel((x + 192) % 384, y)[0]));
    EXPECT_LT(worst, 0.02);
}

TEST_F(DenoiserTest, PolesAreNoWorseThanTheRest) {
    const EquirectCamera camera{384, 192, {}};
    const FloatImage right = clean(camera);
    double at_poles = 0, elsewhere = 0;
    for (unsigned seed = 1; seed <= 4; ++seed) {
        Frame frame = noisy(camera, seed);
        denoiser->denoise(frame);
        const FloatImage& colour = frame.planes["colour"];
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x) {
                const double off = std::pow(double{colour.pixel(x, y)[0]} - right.pixel(x, y)[0], 2);
                (y < 8 || y >= camera.height - 8 ? at_poles : elsewhere) += off;
            }
    }
    EXPECT_LT(at_poles / 16, 1.5 * elsewhere / (camera.height - 16));
}

// Wider than a block: what neighbouring blocks make of a place must be the same.
TEST_F(DenoiserTest, BlocksMeetWithoutABorder) {
    const EquirectCamera wide{5120, 64, {-pi, pi, -0.05, 0.05}};
    Frame frame = noisy(wide);
    denoiser->denoise(frame);
    const FloatImage& colour = frame.planes["colour"];
    double at_border = 0, elsewhere = 0;
    for (int y = 0; y < wide.height; ++y)
        for (int x = 2400; x < 2720; ++x) {
            const double step = std::abs(double{colour.pixel(x + 1, y)[0]} - colour.pixel(x, y)[0]);
            x == 2559 ? at_border += step : elsewhere += step / 319;
        }
    EXPECT_LT(at_border, 1.5 * elsewhere);
}

TEST_F(DenoiserTest, AnySizeIsTaken) {
    for (const auto& [width, height] : {std::pair(1, 1), {3, 1}, {2, 400}, {16384, 2}}) {
        Frame sphere = noisy({width, height, {}});
        denoiser->denoise(sphere);
        Frame view;
        view.info.camera = PerspectiveCamera{width, height, 1};
        view.planes["colour"] = FloatImage(width, height, 4, 0.5f);
        denoiser->denoise(view);
        for (const Frame* frame : {&sphere, &view})
            for (const float value : frame->planes.at("colour").samples())
                ASSERT_TRUE(std::isfinite(value) && value >= 0) << width << "x" << height;
    }
}

TEST_F(DenoiserTest, WhatIsNotFiniteSpoilsNothing) {
    const EquirectCamera camera{256, 128, {}};
    Frame frame = noisy(camera);
    const FloatImage right = clean(camera);
    const float wrong[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                           -std::numeric_limits<float>::infinity(), -1e30f, 1e30f};
    for (int i = 0; i < 5; ++i)
        std::fill_n(frame.planes["colour"].pixel(40 * i + 20, 64), 3, wrong[i]);
    frame.planes["guide_albedo"] = FloatImage(256, 128, 3, wrong[0]);
    frame.planes["guide_normal"] = FloatImage(256, 128, 3, wrong[1]);
    denoiser->denoise(frame);
    for (const float value : frame.planes["colour"].samples())
        ASSERT_TRUE(std::isfinite(value));
    EXPECT_NEAR(frame.planes["colour"].pixel(100, 20)[0], right.pixel(100, 20)[0], 0.2);
}

// A guide that shows an edge keeps it where colour alone is too noisy.
TEST_F(DenoiserTest, GuidesKeepWhatNoiseHides) {
    const EquirectCamera camera{256, 128, {}};
    const auto stripe = [](int x) { return x / 4 % 2 == 0 ? 0.9f : 0.3f; };
    const auto made = [&](bool guided) {
        Frame frame;
        frame.info.camera = camera;
        FloatImage colour(256, 128, 4), albedo(256, 128, 3);
        std::mt19937 random(3);
        std::exponential_distribution<float> noise;
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 256; ++x)
                for (int c = 0; c < 3; ++c) {
                    albedo.pixel(x, y)[c] = stripe(x);
                    colour.pixel(x, y)[c] = stripe(x) * noise(random);
                }
        frame.planes["colour"] = std::move(colour);
        if (guided)
            frame.planes["guide_albedo"] = std::move(albedo);
        denoiser->denoise(frame);
        double sum = 0;
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 256; ++x)
                sum += std::pow(double{frame.planes["colour"].pixel(x, y)[0]} - stripe(x), 2);
        return sum;
    };
    EXPECT_LT(made(true), made(false) / 2);
}

}  // namespace
}  // namespace equistream
