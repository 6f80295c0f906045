#include "gl_fixture.h"

#include <client/view/gl/display.h>

#include <client/view/stereo_layout.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <random>

namespace equistream::test {
namespace {

constexpr gl::Size window{64, 48};

ByteImage random_bytes(int width, int height, unsigned seed) {
    ByteImage image(width, height, 4);
    std::mt19937 random(seed);
    for (std::uint8_t& sample : image.samples())
        sample = std::uint8_t(random() % 256);
    return image;
}

/// Two eyes' pictures of random pixels, and a framebuffer that stands for the window.
class GlDisplay : public Gl {
protected:
    gl::Display display;
    gl::EyeTargets targets, other;
    gl::Texture shown = gl::make_texture(window, GL_RGBA8);
    gl::Framebuffer framebuffer;
    ByteImage left, right;

    void SetUp() override {
        GLuint name = 0;
        glCreateFramebuffers(1, &name);
        framebuffer = gl::Framebuffer(name);
        glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, shown.name(), 0);
    }
    void look(gl::DisplayLayout layout) {
        const gl::Size size = gl::eye_size(layout, window);
        targets.size_for({size.width, size.height, 1.5}, gl::eyes_of(layout));
        left = random_bytes(size.width, size.height, 1);
        right = random_bytes(size.width, size.height, 2);
        upload(targets, 0, left);
        if (gl::eyes_of(layout) == 2)
            upload(targets, 1, right);
    }
    static void upload(const gl::EyeTargets& to, int eye, const ByteImage& rgba) {
        glTextureSubImage3D(to.colour(), 0, 0, 0, eye, rgba.width(), rgba.height(), 1, GL_RGBA, GL_UNSIGNED_BYTE,
                            rgba.samples().data());
    }
    /// Row 0 is the top one.
    ByteImage drawn(const gl::DisplayedPictures& pictures, const gl::DisplayOptions& options) {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
        display.draw(pictures, options, window);
        ByteImage up(window.width, window.height, 4), down(window.width, window.height, 3);
        glReadPixels(0, 0, window.width, window.height, GL_RGBA, GL_UNSIGNED_BYTE, up.samples().data());
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        for (int y = 0; y < window.height; ++y)
            for (int x = 0; x < window.width; ++x)
                std::copy_n(up.pixel(x, window.height - 1 - y), 3, down.pixel(x, y));
        return down;
    }
    /// The largest difference of a channel from what `expected(x, y)` points at.
    template <typename Expected>
    static int worst(const ByteImage& found, Expected expected) {
        int worst = 0;
        for (int y = 0; y < found.height(); ++y)
            for (int x = 0; x < found.width(); ++x)
                for (int c = 0; c < 3; ++c)
                    worst = std::max(worst, std::abs(int(found.pixel(x, y)[c]) - int(expected(x, y)[c])));
        return worst;
    }
};

TEST_F(GlDisplay, OneEyeIsShownAsItIs) {
    look(gl::DisplayLayout::left);
    const ByteImage found = drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::left});
    EXPECT_EQ(worst(found, [&](int x, int y) { return left.pixel(x, y); }), 0);
}

TEST_F(GlDisplay, SideBySideTheLeftEyeIsOnTheLeft) {
    look(gl::DisplayLayout::side_by_side);
    const ByteImage found = drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::side_by_side});
    EXPECT_EQ(worst(found, [&](int x, int y) { return x < 32 ? left.pixel(x, y) : right.pixel(x - 32, y); }), 0);
}

TEST_F(GlDisplay, WithoutAConfidenceMapItsOverlayShowsNothing) {
    look(gl::DisplayLayout::left);
    const ByteImage found =
        drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::left, .overlay = gl::Overlay::reliability});
    EXPECT_EQ(worst(found, [&](int x, int y) { return left.pixel(x, y); }), 0);
}

/// The formula that play uses, on the same bytes.
TEST_F(GlDisplay, AnaglyphsAreThoseOfPlay) {
    look(gl::DisplayLayout::anaglyph);
    const auto rgb = [](const ByteImage& rgba) {
        ByteImage colours(rgba.width(), rgba.height(), 3);
        for (int y = 0; y < rgba.height(); ++y)
            for (int x = 0; x < rgba.width(); ++x)
                std::copy_n(rgba.pixel(x, y), 3, colours.pixel(x, y));
        return colours;
    };
    for (const Anaglyph& kind : anaglyphs()) {
        const ByteImage found = drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::anaglyph, .anaglyph = &kind});
        const ByteImage expected = make_anaglyph(kind, rgb(left).view(), rgb(right).view());
        EXPECT_LE(worst(found, [&](int x, int y) { return expected.pixel(x, y); }), 1) << kind.name;
    }
}

TEST_F(GlDisplay, ASplitShowsTheOtherOnItsRight) {
    look(gl::DisplayLayout::left);
    other.size_for({window.width, window.height, 1.5}, 1);
    const ByteImage others = random_bytes(window.width, window.height, 3);
    upload(other, 0, others);
    const ByteImage found =
        drawn({.eyes = &targets, .other = &other}, {.layout = gl::DisplayLayout::left, .split = 0.25f});
    for (int y = 0; y < window.height; ++y)
        for (int x = 0; x < window.width; ++x)
            if (std::abs(x - 15.5) > 1.6) {
                EXPECT_EQ(found.pixel(x, y)[1], (x < 16 ? left : others).pixel(x, y)[1]) << x << ' ' << y;
            }
    EXPECT_EQ(found.pixel(16, 7)[0], 255);
}

/// Direction by hue, speed by brightness; what rests is grey, and the legend has the colour of each direction.
TEST_F(GlDisplay, MotionIsHueAndBrightness) {
    look(gl::DisplayLayout::left);
    const gl::Texture motion = gl::make_layered_texture(window, 1, GL_RGBA16F);
    const auto full = float(gl::full_motion_deg_per_s * pi / 180);
    const auto shown_for = [&](float to_right, float down, float moves) {
        const float texel[] = {to_right, down, moves, 0};
        glClearTexImage(motion.name(), 0, GL_RGBA, GL_FLOAT, texel);
        return drawn({.eyes = &targets, .motion = motion.name()}, {.overlay = gl::Overlay::motion});
    };
    const auto at = [](const ByteImage& image) {
        return glm::ivec3(image.pixel(3, 3)[0], image.pixel(3, 3)[1], image.pixel(3, 3)[2]);
    };
    const auto expect = [&](const ByteImage& image, const glm::ivec3& colour, const char* what) {
        const glm::ivec3 off = glm::abs(at(image) - colour);
        EXPECT_LE(std::max({off.r, off.g, off.b}), 1) << what;
    };
    expect(shown_for(full, 0, 1), {255, 0, 0}, "right");
    expect(shown_for(-full, 0, 1), {0, 255, 255}, "left");
    expect(shown_for(0, -full, 1), {128, 255, 0}, "up");
    expect(shown_for(0, full, 1), {128, 0, 255}, "down");
    expect(shown_for(0.5f * full, 0, 1), {128, 0, 0}, "slower");
    expect(shown_for(3 * full, 0, 1), {255, 0, 0}, "no brighter than full");
    const glm::ivec3 rests = at(shown_for(full, 0, 0)),
                     unknown = at(drawn({.eyes = &targets}, {.overlay = gl::Overlay::motion}));
    EXPECT_EQ(rests.r, rests.g);
    EXPECT_EQ(rests.g, rests.b);
    EXPECT_EQ(rests, unknown);
}

/// A lens of no power changes nothing; a real one leaves the middle and shows the corners dark.
TEST_F(GlDisplay, LensesBendTowardsTheMiddle) {
    look(gl::DisplayLayout::headset);
    const gl::DisplayOptions flat{.layout = gl::DisplayLayout::headset, .lens = {0, 0}};
    const ByteImage same = drawn({.eyes = &targets}, flat);
    EXPECT_LE(worst(same, [&](int x, int y) { return x < 32 ? left.pixel(x, y) : right.pixel(x - 32, y); }), 1);
    const ByteImage bent = drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::headset});
    EXPECT_EQ(bent.pixel(0, 0)[0] + bent.pixel(63, 47)[2], 0);
    EXPECT_GT(worst(bent, [&](int x, int y) { return same.pixel(x, y); }), 30);
}

/// Outside the head box pictures go to grey, not to black.
TEST_F(GlDisplay, FadingGoesToGrey) {
    look(gl::DisplayLayout::left);
    const ByteImage found = drawn({.eyes = &targets}, {.layout = gl::DisplayLayout::left, .fading = 1});
    for (const std::uint8_t sample : found.samples()) {
        EXPECT_GE(sample, 0.6 * 127);
        EXPECT_LE(sample, 255 - 0.6 * 127);
    }
    for (int x = 0; x < window.width; ++x)
        EXPECT_EQ(found.pixel(x, 20)[0], found.pixel(x, 20)[2]) << x;
}

}  // namespace
}  // namespace equistream::test
