#include <equistream/colour.h>
#include <equistream/error.h>
#include <tests/comma_locale.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <string>

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
    for (const double exposure : {0.0, -1.0, std::nan(""), HUGE_VAL}) {
        EXPECT_THROW(transform.to_display(image.view(), exposure), InputError);
        EXPECT_THROW(transform.to_linear(image.view(), exposure), InputError);
        EXPECT_THROW(PqEncoding().encode(image.view(), exposure), InputError);
    }
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

namespace {

/// Of HdrDisplaySettings, by what is not the default.
struct Chosen {
    std::string config{}, display{}, view{};
    double exposure_stops = 0;

    operator HdrDisplaySettings() const { return {config, display, view, exposure_stops}; }
};

/// SMPTE ST 2084's inverse curve, of nits, written down independently of OpenColorIO.
double pq_of_nits(double nits) {
    const double y = std::pow(nits / 10000, 2610.0 / 16384);
    return std::pow((3424.0 / 4096 + 2413.0 / 128 * y) / (1 + 2392.0 / 128 * y), 2523.0 / 32);
}

/// BT.2087: linear BT.709 to linear BT.2020.
constexpr double to_2020[3][3] = {{0.6274, 0.3293, 0.0433}, {0.0691, 0.9195, 0.0114}, {0.0164, 0.0880, 0.8956}};

/// Log-uniform from a ten-thousandth of white to twenty times white.
FloatImage bright_colours(int width, int height) {
    std::mt19937 generator(11);
    std::uniform_real_distribution<float> exponent(-4, 1.3f);
    FloatImage image(width, height, 3);
    for (float& sample : image.samples())
        sample = std::pow(10.0f, exponent(generator));
    return image;
}

TEST(HdrDisplay, PqIsTheStandardsFormula) {
    const FloatImage linear = bright_colours(61, 47);
    const FloatImage pq = PqEncoding().encode(linear.view(), 1.5);
    double worst = 0;
    for (std::size_t i = 0; i < linear.samples().size(); i += 3)
        for (std::size_t c = 0; c < 3; ++c) {
            double light = 0;
            for (std::size_t k = 0; k < 3; ++k)
                light += to_2020[c][k] * double(linear.samples()[i + k]);
            worst = std::max(worst, std::abs(pq.samples()[i + c] - pq_of_nits(203 * 1.5 * light)));
        }
    EXPECT_LT(worst, 4e-4);  // a third of a 10-bit step
}

TEST(HdrDisplay, WhatIsNotFiniteOrTooBrightIsWithinPq) {
    FloatImage odd(4, 1, 3, std::nanf(""));
    odd.pixel(1, 0)[0] = HUGE_VALF;
    odd.pixel(2, 0)[1] = -HUGE_VALF;
    const FloatImage pq = PqEncoding().encode(odd.view(), 1);
    for (const float sample : pq.samples()) {
        EXPECT_GE(sample, 0);
        EXPECT_LE(sample, 1);
    }
}

TEST(HdrDisplay, AsksForNothingAndShowsWhatSrgbStreamsShow) {
    const FloatImage linear = bright_colours(64, 32);
    const FloatImage direct = DisplayTransform().to_display(linear.view(), 0.7);
    const FloatImage shown = HdrDisplay().to_display(PqEncoding().encode(linear.view(), 0.7).view());
    double worst = 0;
    for (std::size_t i = 0; i < direct.samples().size(); ++i)
        worst = std::max(worst, std::abs(double(direct.samples()[i]) - double(shown.samples()[i])));
    EXPECT_LT(worst, 0.5 / 255);
}

TEST(HdrDisplay, PqDisplaysShowPqAsItIs) {
    FloatImage pq = PqEncoding().encode(bright_colours(64, 32).view(), 1);
    const FloatImage shown =
        HdrDisplay(Chosen{.display = "Rec.2100-PQ - Display", .view = default_view}).to_display(pq.view());
    double worst = 0;
    for (std::size_t i = 0; i < pq.samples().size(); ++i)
        worst = std::max(worst, std::abs(double(shown.samples()[i]) - double(pq.samples()[i])));
    EXPECT_LT(worst, 4e-4);  // a third of a 10-bit step
}

TEST(HdrDisplay, AStopDoublesLight) {
    const FloatImage pq = PqEncoding().encode(bright_colours(40, 40).view(), 1);
    const FloatImage light = DisplayTransform().to_linear(HdrDisplay().to_display(pq.view()).view(), 1);
    const FloatImage less =
        DisplayTransform().to_linear(HdrDisplay(Chosen{.exposure_stops = -1}).to_display(pq.view()).view(), 1);
    int compared = 0;
    for (std::size_t i = 0; i < light.samples().size(); ++i)
        if (light.samples()[i] > 0.01f && light.samples()[i] < 0.99f) {
            EXPECT_NEAR(less.samples()[i] / light.samples()[i], 0.5, 2e-3);
            ++compared;
        }
    EXPECT_GT(compared, 500);
}

TEST(HdrDisplay, AFilmicViewKeepsHighlightsApart) {
    FloatImage linear(2, 1, 3, 4.0f);
    linear.pixel(1, 0)[0] = linear.pixel(1, 0)[1] = linear.pixel(1, 0)[2] = 8.0f;
    const FloatImage pq = PqEncoding().encode(linear.view(), 1);
    const FloatImage clipped = HdrDisplay().to_display(pq.view());
    const FloatImage filmic = HdrDisplay(Chosen{.view = "ACES 1.0 - SDR Video"}).to_display(pq.view());
    EXPECT_EQ(clipped.samples()[0], clipped.samples()[3]);
    EXPECT_LT(filmic.samples()[0] + 0.01f, filmic.samples()[3]);
}

TEST(HdrDisplay, WhatIsNotAskedForIsTheDefault) {
    EXPECT_EQ(HdrDisplay().settings().display, "sRGB - Display");
    EXPECT_EQ(HdrDisplay().settings().view, default_view);
    EXPECT_EQ(HdrDisplay(Chosen{.display = "Rec.2100-PQ - Display"}).settings().view,
              "ACES 1.1 - HDR Video (1000 nits & Rec.2020 lim)");
}

/// Graphics cards get the same in a function and tables, with the exposure left open.
TEST(HdrDisplay, TheShaderNamesItsTablesAndItsExposure) {
    for (const char* view : {"ACES 1.0 - SDR Video", "Un-tone-mapped"}) {
        const DisplayShader shader = HdrDisplay(Chosen{.view = view, .exposure_stops = 1}).shader();
        EXPECT_NE(shader.text.find(DisplayShader::function), std::string::npos);
        EXPECT_NE(shader.text.find("uniform float " + shader.exposure_uniform), std::string::npos)
            << shader.exposure_uniform;
        for (const ShaderTable& table : shader.tables) {
            EXPECT_NE(shader.text.find(table.sampler), std::string::npos);
            EXPECT_EQ(table.values.size(), std::size_t(table.width) * std::size_t(std::max(table.height, 1)) *
                                               std::size_t(std::max(table.depth, 1)) * std::size_t(table.channels));
        }
        EXPECT_FALSE(shader.tables.empty());
    }
}

TEST(Colour, IsTheSameInEveryLocaleOfTheHostWhichKeepsIt) {
    const FloatImage linear = random_image(16, 8, 3, 0, 1);
    const FloatImage srgb = DisplayTransform().to_display(linear.view(), 1), pq = PqEncoding().encode(linear.view(), 1);
    const FloatImage shown = HdrDisplay().to_display(pq.view());
    const std::string shader = HdrDisplay().shader().text;
    const testing::CommaLocale of_host;
    EXPECT_TRUE(std::ranges::equal(DisplayTransform().to_display(linear.view(), 1).samples(), srgb.samples()));
    EXPECT_TRUE(std::ranges::equal(PqEncoding().encode(linear.view(), 1).samples(), pq.samples()));
    EXPECT_TRUE(std::ranges::equal(HdrDisplay().to_display(pq.view()).samples(), shown.samples()));
    EXPECT_EQ(HdrDisplay().shader().text, shader);
    EXPECT_EQ(std::locale().name(), "comma");
    EXPECT_STREQ(std::localeconv()->decimal_point, ",");
    std::setlocale(LC_ALL, "C");  // of C functions alone
    const HdrDisplay another;
    EXPECT_EQ(std::locale().name(), "comma");
    EXPECT_STREQ(std::localeconv()->decimal_point, ".");
}

std::string refusal(const HdrDisplaySettings& settings) {
    try {
        const HdrDisplay display(settings);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(HdrDisplay, WhatItDoesNotKnowIsSaidInOneLine) {
    const auto says = [](const HdrDisplaySettings& settings, const char* text) {
        EXPECT_NE(refusal(settings).find(text), std::string::npos) << refusal(settings);
    };
    says(Chosen{.view = "Filmic"}, "view: expected one of \"ACES 1.0 - SDR Video\", \"Un-tone-mapped\"");
    says(Chosen{.display = "TV"}, "display: expected one of \"sRGB - Display\"");
    for (const double stops : {-20.0, 20.0})
        EXPECT_EQ(refusal(Chosen{.exposure_stops = stops}), "");
    says(Chosen{.exposure_stops = 21}, "exposure: expected -20 to 20 stops, found 21");
    says(Chosen{.exposure_stops = std::nan("")}, "exposure: expected");
    const std::string text = refusal(Chosen{.config = "/no/such/config.ocio"});
    EXPECT_EQ(text.find("/no/such/config.ocio: expected an OpenColorIO config"), 0u) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace equistream
