#include <tests/unit/evidence.h>

#include <client/view/stereo_layout.h>
#include <equistream/error.h>
#include <equistream/rec709.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace equistream::test {
namespace {

ByteImage noise(unsigned seed, int width = 61, int height = 17) {
    ByteImage picture(width, height, 3);
    std::mt19937 random(seed);
    for (std::uint8_t& byte : picture.samples())
        byte = std::uint8_t(random());
    return picture;
}

glm::vec3 linear(const std::uint8_t* rgb) {
    return {srgb_to_linear(float(rgb[0]) / 255), srgb_to_linear(float(rgb[1]) / 255),
            srgb_to_linear(float(rgb[2]) / 255)};
}

TEST(StereoLayout, ColourTakesChannelsAsTheyAre) {
    const ByteImage left = noise(3), right = noise(4);
    const ByteImage both = make_anaglyph(find_anaglyph("colour"), left.view(), right.view());
    for (int y = 0; y < left.height(); ++y)
        for (int x = 0; x < left.width(); ++x) {
            EXPECT_EQ(both.pixel(x, y)[0], left.pixel(x, y)[0]);
            EXPECT_EQ(both.pixel(x, y)[1], right.pixel(x, y)[1]);
            EXPECT_EQ(both.pixel(x, y)[2], right.pixel(x, y)[2]);
        }
}

/// The formula in double precision, rounded.
TEST(StereoLayout, EveryKindIsItsMatrices) {
    const ByteImage left = noise(5), right = noise(6);
    for (const Anaglyph& kind : anaglyphs()) {
        const ByteImage both = make_anaglyph(kind, left.view(), right.view());
        for (int y = 0; y < left.height(); ++y)
            for (int x = 0; x < left.width(); ++x) {
                const glm::dvec3 light = glm::dmat3(kind.from_left) * glm::dvec3(linear(left.pixel(x, y))) +
                                         glm::dmat3(kind.from_right) * glm::dvec3(linear(right.pixel(x, y)));
                for (int channel = 0; channel < 3; ++channel) {
                    const double shown = linear_to_srgb(float(glm::clamp(light[channel], 0.0, 1.0)));
                    EXPECT_NEAR(both.pixel(x, y)[channel], 255 * shown, 0.51) << kind.name;
                }
            }
    }
}

/// White stays white and black black, for the eyes' pictures and their glasses alike.
TEST(StereoLayout, GreysKeepTheirLuminance) {
    for (const Anaglyph& kind : anaglyphs()) {
        const glm::vec3 white = kind.from_left * glm::vec3(1) + kind.from_right * glm::vec3(1);
        EXPECT_NEAR(luminance(white), 1, 0.01) << kind.name;
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(white[channel], 1, 0.01) << kind.name;
    }
}

/// What glasses let through of the wrong eye: Dubois' matrices may use it to keep colours, the others do not.
TEST(StereoLayout, EachEyeHasItsOwnChannels) {
    for (const char* name : {"colour", "half-colour", "grey"}) {
        const Anaglyph& kind = find_anaglyph(name);
        for (int from = 0; from < 3; ++from) {
            EXPECT_EQ(kind.from_left[from][1], 0) << name;
            EXPECT_EQ(kind.from_left[from][2], 0) << name;
            EXPECT_EQ(kind.from_right[from][0], 0) << name;
        }
    }
}

TEST(StereoLayout, UnknownKindsAreNamed) {
    try {
        find_anaglyph("purple");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_STREQ(e.what(), "--anaglyph: expected dubois, colour, half-colour or grey, found 'purple'");
    }
}

}  // namespace
}  // namespace equistream::test
