#include <equistream/colour.h>
#include <equistream/error.h>

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <string>

namespace equistream {
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
    says(Chosen{.exposure_stops = 21}, "exposure: expected -20 to 20 stops, found 21");
    says(Chosen{.exposure_stops = std::nan("")}, "exposure: expected");
    const std::string text = refusal(Chosen{.config = "/no/such/config.ocio"});
    EXPECT_EQ(text.find("/no/such/config.ocio: expected an OpenColorIO config"), 0u) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace equistream
