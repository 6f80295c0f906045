#include <equistream/stream.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace equistream {
namespace {

ByteImage noise(unsigned seed) {
    std::mt19937 random(seed);
    ByteImage picture(7, 5, 3);
    for (std::uint8_t& sample : picture.samples())
        sample = std::uint8_t(random());
    return picture;
}

TEST(StereoPacking, LeftIsOnTheLeftOrAbove) {
    const ByteImage left = noise(1), right = noise(2);
    const ByteImage beside = packed_eyes(StereoPacking::side_by_side, left.view(), right.view());
    const ByteImage above = packed_eyes(StereoPacking::top_bottom, left.view(), right.view());
    ASSERT_EQ(beside.width(), 14);
    ASSERT_EQ(beside.height(), 5);
    ASSERT_EQ(above.width(), 7);
    ASSERT_EQ(above.height(), 10);
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 7; ++x) {
            EXPECT_TRUE(std::equal(left.pixel(x, y), left.pixel(x, y) + 3, beside.pixel(x, y)));
            EXPECT_TRUE(std::equal(right.pixel(x, y), right.pixel(x, y) + 3, beside.pixel(7 + x, y)));
            EXPECT_TRUE(std::equal(left.pixel(x, y), left.pixel(x, y) + 3, above.pixel(x, y)));
            EXPECT_TRUE(std::equal(right.pixel(x, y), right.pixel(x, y) + 3, above.pixel(x, 5 + y)));
        }
}

}  // namespace

namespace {

struct Planes {
    Planes(int width, int height) : y(width, height, 1), cb(width / 2, height / 2, 1), cr(width / 2, height / 2, 1) {}
    Yuv420View<std::uint8_t> view() { return {y.view(), cb.view(), cr.view()}; }
    Yuv420View<const std::uint8_t> const_view() const { return {y.view(), cb.view(), cr.view()}; }
    ByteImage y, cb, cr;
};

ByteImage random_bytes(int width, int height, int channels, unsigned seed) {
    std::mt19937 generator(seed);
    ByteImage image(width, height, channels);
    for (auto& sample : image.samples())
        sample = static_cast<std::uint8_t>(generator());
    return image;
}

double luma(const std::uint8_t* rgb) {
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// The formula in real numbers, pixel by pixel, with the picture's border repeated.
double chroma(const ByteImage& rgb, int i, int j, int channel, double divisor) {
    double sum = 0;
    for (int dy = 0; dy < 2; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
            const auto* p = rgb.pixel(std::clamp(2 * i + dx, 0, rgb.width() - 1), 2 * j + dy);
            sum += (dx == 0 ? 0.25 : 0.125) * (p[channel] - luma(p)) / divisor;
        }
    return 128 + 224.0 / 255 * sum;
}

void expect_rounded(int found, double exact) {
    EXPECT_LT(std::abs(found - std::clamp(exact, 0.0, 255.0)), 0.51) << exact;
}

TEST(Yuv420, DownIsTheFormula) {
    const ByteImage rgb = random_bytes(70, 46, 3, 1);
    Planes planes(70, 46);
    rgb_to_yuv420(rgb.view(), planes.view());
    for (int y = 0; y < 46; ++y)
        for (int x = 0; x < 70; ++x)
            expect_rounded(*planes.y.pixel(x, y), 16 + 219.0 / 255 * luma(rgb.pixel(x, y)));
    for (int j = 0; j < 23; ++j)
        for (int i = 0; i < 35; ++i) {
            expect_rounded(*planes.cb.pixel(i, j), chroma(rgb, i, j, 2, 1.8556));
            expect_rounded(*planes.cr.pixel(i, j), chroma(rgb, i, j, 0, 1.5748));
        }
}

/// Linear interpolation at a real position, the border repeated.
double sampled(const ByteImage& plane, double x, double y) {
    const double fx = std::floor(x), fy = std::floor(y);
    const auto at = [&](double i, double j) {
        return double(
            *plane.pixel(std::clamp(int(i), 0, plane.width() - 1), std::clamp(int(j), 0, plane.height() - 1)));
    };
    const double u = x - fx, v = y - fy;
    return (1 - v) * ((1 - u) * at(fx, fy) + u * at(fx + 1, fy)) +
           v * ((1 - u) * at(fx, fy + 1) + u * at(fx + 1, fy + 1));
}

TEST(Yuv420, UpIsTheFormula) {
    Planes planes(52, 34);
    planes.y = random_bytes(52, 34, 1, 2);
    planes.cb = random_bytes(26, 17, 1, 3);
    planes.cr = random_bytes(26, 17, 1, 4);
    ByteImage rgb(52, 34, 3);
    yuv420_to_rgb(planes.const_view(), rgb.view());
    for (int y = 0; y < 34; ++y)
        for (int x = 0; x < 52; ++x) {
            const double l = (*planes.y.pixel(x, y) - 16) * 255.0 / 219;
            const double b = (sampled(planes.cb, x / 2.0, (y - 0.5) / 2) - 128) * 255 / 224;
            const double r = (sampled(planes.cr, x / 2.0, (y - 0.5) / 2) - 128) * 255 / 224;
            const double red = l + 1.5748 * r, blue = l + 1.8556 * b;
            expect_rounded(rgb.pixel(x, y)[0], red);
            expect_rounded(rgb.pixel(x, y)[1], (l - 0.2126 * red - 0.0722 * blue) / 0.7152);
            expect_rounded(rgb.pixel(x, y)[2], blue);
        }
}

TEST(Yuv420, GreysAreExact) {
    for (int grey = 0; grey < 256; ++grey) {
        const ByteImage rgb(4, 2, 3, static_cast<std::uint8_t>(grey));
        Planes planes(4, 2);
        rgb_to_yuv420(rgb.view(), planes.view());
        ByteImage again(4, 2, 3);
        yuv420_to_rgb(planes.const_view(), again.view());
        EXPECT_EQ(*planes.cb.pixel(1, 0), 128);
        for (const int found : again.samples())
            EXPECT_NEAR(found, grey, 1);
    }
}

TEST(Yuv420, PaddedRowsAreLeftAlone) {
    const ByteImage wide = random_bytes(64, 8, 3, 5);
    ImageView<const std::uint8_t> part = wide.view();
    part.width = 30;
    Planes planes(64, 8);
    planes.y = ByteImage(64, 8, 1, 77);
    auto target = planes.view();
    target.y.width = 30;
    target.cb.width = target.cr.width = 15;
    rgb_to_yuv420(part, target);
    for (int y = 0; y < 8; ++y)
        for (int x = 30; x < 64; ++x)
            EXPECT_EQ(*planes.y.pixel(x, y), 77);
}

}  // namespace
}  // namespace equistream
