#include <equistream/colour.h>
#include <equistream/error.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace equistream {
namespace {

/// IEC 61966-2-1, written down independently of OpenColorIO.
double srgb_encoded(double linear) {
    const double x = std::clamp(linear, 0.0, 1.0);
    return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055;
}

double srgb_decoded(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

FloatImage random_image(int width, int height, int channels, float low, float high) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> value(low, high);
    FloatImage image(width, height, channels);
    for (float& sample : image.samples())
        sample = value(generator);
    return image;
}

TEST(DisplayTransform, IsTheClosedFormOfSrgb) {
    const FloatImage linear = random_image(257, 131, 3, -0.2f, 1.4f);
    const double exposure = 1.7;
    const FloatImage display = DisplayTransform().to_display(linear.view(), exposure);
    ASSERT_EQ(display.channels(), 3);
    double worst = 0;
    for (std::size_t i = 0; i < linear.samples().size(); ++i)
        worst = std::max(worst, std::abs(display.samples()[i] - srgb_encoded(exposure * linear.samples()[i])));
    EXPECT_LT(worst, 2e-5);  // a hundredth of an 8-bit step is 4e-5
}

TEST(DisplayTransform, DarkTonesKeepTheirRelativePrecision) {
    const FloatImage linear = random_image(64, 64, 3, 1e-5f, 3e-3f);
    const FloatImage display = DisplayTransform().to_display(linear.view(), 1);
    for (std::size_t i = 0; i < linear.samples().size(); ++i)
        EXPECT_NEAR(display.samples()[i] / srgb_encoded(linear.samples()[i]), 1, 3e-4);  // OCIO's slope is 12.9232
}

TEST(DisplayTransform, LinearIsTheInverse) {
    const DisplayTransform transform;
    const FloatImage display = random_image(200, 90, 3, 0.0f, 1.0f);
    const FloatImage linear = transform.to_linear(display.view(), 2.5);
    for (std::size_t i = 0; i < display.samples().size(); ++i)
        EXPECT_NEAR(linear.samples()[i], srgb_decoded(display.samples()[i]) / 2.5, 1e-5);
    const FloatImage again = transform.to_display(linear.view(), 2.5);
    for (std::size_t i = 0; i < display.samples().size(); ++i)
        EXPECT_NEAR(again.samples()[i], display.samples()[i], 3e-5);
}

TEST(DisplayTransform, EveryByteSurvivesTheRoundTrip) {
    const DisplayTransform transform;
    ByteImage bytes(256, 1, 3);
    for (int i = 0; i < 256; ++i)
        for (int c = 0; c < 3; ++c)
            bytes.pixel(i, 0)[c] = static_cast<std::uint8_t>(c == 1 ? 255 - i : i);
    const FloatImage linear = transform.to_linear(widen_8bit(bytes.view()).view(), 0.3);
    const ByteImage again = quantise_8bit(transform.to_display(linear.view(), 0.3).view());
    EXPECT_TRUE(std::equal(bytes.samples().begin(), bytes.samples().end(), again.samples().begin()));
}

TEST(DisplayTransform, AlphaIsDroppedAndStridesAreKept) {
    const FloatImage wide = random_image(40, 20, 4, 0, 1);
    ImageView<const float> part = wide.view();
    part.width = 17;
    const FloatImage display = DisplayTransform().to_display(part, 1);
    ASSERT_EQ(display.width(), 17);
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 17; ++x)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(display.pixel(x, y)[c], srgb_encoded(wide.pixel(x, y)[c]), 2e-5);
}

TEST(DisplayTransform, NotFiniteIsBlackOrWhite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const float infinity = std::numeric_limits<float>::infinity();
    for (const char* view : {"Un-tone-mapped", "ACES 1.0 - SDR Video", "Raw"}) {
        FloatImage image(3, 1, 3, nan);
        std::fill_n(image.pixel(1, 0), 3, infinity);
        std::fill_n(image.pixel(2, 0), 3, -infinity);
        const FloatImage display = DisplayTransform(view).to_display(image.view(), 4);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(display.pixel(0, 0)[c], 0, 1e-3) << view;
            EXPECT_NEAR(display.pixel(1, 0)[c], 1, 1e-2) << view;
            EXPECT_NEAR(display.pixel(2, 0)[c], 0, 1e-3) << view;
        }
    }
}

TEST(DisplayTransform, AHotChannelDoesNotTintItsNeighbours) {
    FloatImage image(1, 1, 3);
    const float hot[] = {60000.0f, 0.2f, 0.05f};
    std::copy(hot, hot + 3, image.pixel(0, 0));
    const FloatImage display = DisplayTransform().to_display(image.view(), 1);
    EXPECT_EQ(display.pixel(0, 0)[0], 1.0f);
    EXPECT_NEAR(display.pixel(0, 0)[1], srgb_encoded(0.2), 1e-4);
    EXPECT_NEAR(display.pixel(0, 0)[2], srgb_encoded(0.05), 1e-4);
}

TEST(DisplayTransform, UnknownViewListsTheAcceptedOnes) {
    try {
        DisplayTransform transform("Filmic");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(),
                     "view: expected one of \"ACES 1.0 - SDR Video\", \"Un-tone-mapped\", \"Raw\", found \"Filmic\"");
    }
}

TEST(DisplayTransform, ExposureMustBePositive) {
    const DisplayTransform transform;
    const FloatImage image(2, 2, 3, 0.5f);
    for (const double exposure : {0.0, -1.0, std::nan(""), HUGE_VAL})
        EXPECT_THROW(transform.to_display(image.view(), exposure), InputError);
}

TEST(Quantise, RoundsClampsAndMakesNanBlack) {
    const std::pair<float, int> cases[] = {{0.0f, 0},  {1.0f, 255}, {0.5f / 255 - 1e-6f, 0}, {0.5f / 255, 1},
                                           {-3.0f, 0}, {7.0f, 255}, {std::nanf(""), 0},      {0.5f, 128}};
    for (const auto& [value, expected] : cases) {
        const FloatImage image(1, 1, 3, value);
        EXPECT_EQ(quantise_8bit(image.view()).pixel(0, 0)[0], expected) << value;
    }
}

TEST(Quantise, WideningIsExactlyInverted) {
    ByteImage bytes(256, 1, 1);
    for (int i = 0; i < 256; ++i)
        *bytes.pixel(i, 0) = static_cast<std::uint8_t>(i);
    const ByteImage again = quantise_8bit(widen_8bit(bytes.view()).view());
    EXPECT_TRUE(std::equal(bytes.samples().begin(), bytes.samples().end(), again.samples().begin()));
}

}  // namespace
}  // namespace equistream
