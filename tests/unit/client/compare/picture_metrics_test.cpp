#include <client/compare/picture_metrics.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace equistream {
namespace {

ByteImage random_picture(int width, int height, unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_int_distribution<int> value(0, 255);
    ByteImage picture(width, height, 3);
    for (std::uint8_t& sample : picture.samples())
        sample = static_cast<std::uint8_t>(value(generator));
    return picture;
}

/// A smooth picture and the same one with some noise: SSIM well away from both 0 and 1.
std::array<ByteImage, 2> alike_pictures(int width, int height, unsigned seed) {
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise(0, 12);
    std::array<ByteImage, 2> pictures{ByteImage(width, height, 3), ByteImage(width, height, 3)};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                const double value = 128 + 90 * std::sin(0.11 * x + c) * std::cos(0.07 * y - c);
                pictures[0].pixel(x, y)[c] = static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
                pictures[1].pixel(x, y)[c] =
                    static_cast<std::uint8_t>(std::clamp(value + noise(generator), 0.0, 255.0));
            }
    return pictures;
}

/// SSIM as its formula reads, in double precision, window by window.
double plain_similarity(const ByteImage& a, const ByteImage& b) {
    double weight[11][11];
    double total = 0;
    for (int v = -5; v <= 5; ++v)
        for (int u = -5; u <= 5; ++u)
            total += weight[v + 5][u + 5] = std::exp(-(u * u + v * v) / (2 * 1.5 * 1.5));
    double sum = 0;
    std::int64_t windows = 0;
    for (int y = 5; y < a.height() - 5; ++y)
        for (int x = 5; x < a.width() - 5; ++x)
            for (int c = 0; c < 3; ++c, ++windows) {
                double ma = 0, mb = 0, va = 0, vb = 0, ab = 0;
                for (int v = -5; v <= 5; ++v)
                    for (int u = -5; u <= 5; ++u) {
                        const double w = weight[v + 5][u + 5] / total;
                        const double pa = a.pixel(x + u, y + v)[c];
                        const double pb = b.pixel(x + u, y + v)[c];
                        ma += w * pa, mb += w * pb, va += w * pa * pa, vb += w * pb * pb, ab += w * pa * pb;
                    }
                va -= ma * ma, vb -= mb * mb, ab -= ma * mb;
                const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
                sum += (2 * ma * mb + c1) * (2 * ab + c2) / ((ma * ma + mb * mb + c1) * (va + vb + c2));
            }
    return sum / static_cast<double>(windows);
}

TEST(Psnr, ConstantDifferenceHasItsClosedForm) {
    const ByteImage a(50, 40, 3, 100);
    for (const int d : {1, 7, 60}) {
        const ByteImage b(50, 40, 3, static_cast<std::uint8_t>(100 + d));
        EXPECT_NEAR(total_error(squared_errors(a.view(), b.view())).psnr_db(), 20 * std::log10(255.0 / d), 1e-9);
    }
}

TEST(Psnr, IdenticalIsInfiniteAndNothingIsNotANumber) {
    const ByteImage a = random_picture(31, 17, 1);
    EXPECT_TRUE(std::isinf(total_error(squared_errors(a.view(), a.view())).psnr_db()));
    EXPECT_TRUE(std::isnan(ErrorSum{}.psnr_db()));
}

TEST(Psnr, PoolingAddsSquaredErrorsNotDecibels) {
    ErrorSum pooled{100, 10};
    pooled += {300, 30};
    EXPECT_DOUBLE_EQ(pooled.mean_square(), 10);
}

TEST(Psnr, MaskedErrorsAreThoseInsideTheMask) {
    const ByteImage a = random_picture(40, 30, 2);
    const ByteImage b = random_picture(40, 30, 3);
    ByteImage mask(40, 30, 1);
    double expected = 0;
    int inside = 0;
    for (int y = 0; y < 30; ++y)
        for (int x = (y * 7) % 5; x < 40; x += 5, ++inside) {
            *mask.pixel(x, y) = 255;
            for (int c = 0; c < 3; ++c)
                expected += std::pow(a.pixel(x, y)[c] - b.pixel(x, y)[c], 2);
        }
    const ErrorSum masked = total_error_where(squared_errors(a.view(), b.view()), mask.view());
    EXPECT_DOUBLE_EQ(masked.sum, expected);
    EXPECT_DOUBLE_EQ(masked.samples, 3 * inside);
}

TEST(Psnr, WorstPixelsAreTheWorstOfAllFramesTogether) {
    ErrorPlane first(100, 10, 1), second(100, 10, 1);  // 2,000 pixels: the worst 1 % are 20
    for (int i = 0; i < 1000; ++i) {
        first.samples()[static_cast<std::size_t>((i * 37) % 1000)] = static_cast<std::uint32_t>(i);
        second.samples()[static_cast<std::size_t>(i)] = 5;
    }
    ErrorHistogram histogram;
    histogram.add(first);
    ErrorHistogram more;
    more.add(second);
    histogram.add(more);
    const ErrorSum worst = histogram.worst(0.01);
    EXPECT_DOUBLE_EQ(worst.sum, 20 * (980 + 999) / 2.0);
    EXPECT_DOUBLE_EQ(worst.samples, 60);
}

TEST(WsPsnr, WeighsPixelsByTheirSolidAngle) {
    const int width = 64, height = 32;
    ByteImage a(width, height, 3, 50), b(width, height, 3, 50);
    for (int x = 0; x < width; ++x)
        a.pixel(x, 0)[0] = 60;  // an error of 10 in one channel of the top row
    const ErrorSum error = sphere_error(squared_errors(a.view(), b.view()), {});
    const double cap = 2 * pi * (1 - std::cos(pi / height));
    EXPECT_NEAR(error.samples, 3 * 4 * pi, 1e-9);
    EXPECT_NEAR(error.sum, 100 * cap, 1e-9);
}

TEST(Ssim, EqualsThePlainFormula) {
    for (const auto& [width, height] : {std::pair{11, 11}, {64, 48}, {97, 33}}) {
        const auto [a, b] = alike_pictures(width, height, 4);
        const Similarity similarity = structural_similarity(a.view(), b.view());
        EXPECT_NEAR(similarity.all.mean(), plain_similarity(a, b), 2e-5) << width << "x" << height;
        EXPECT_EQ(similarity.all.windows, 3.0 * (width - 10) * (height - 10));
        EXPECT_EQ(similarity.masked.windows, 0);
    }
}

TEST(Ssim, IsOneForIdenticalPicturesAndTheLuminanceTermForConstants) {
    const ByteImage noise = random_picture(60, 40, 5);
    EXPECT_NEAR(structural_similarity(noise.view(), noise.view()).all.mean(), 1, 1e-5);
    for (const auto& [p, t] : {std::pair{0, 255}, {250, 255}, {3, 5}}) {
        const ByteImage a(30, 30, 3, static_cast<std::uint8_t>(p));
        const ByteImage b(30, 30, 3, static_cast<std::uint8_t>(t));
        const double c1 = 2.55 * 2.55;
        EXPECT_NEAR(structural_similarity(a.view(), b.view()).all.mean(), (2.0 * p * t + c1) / (p * p + t * t + c1),
                    1e-4);
    }
}

TEST(Ssim, MaskSelectsWindowsByTheirCentre) {
    const auto [a, b] = alike_pictures(40, 40, 6);
    ByteImage everywhere(40, 40, 1, 1), one(40, 40, 1, 0);
    *one.pixel(20, 13) = 255;
    const Similarity all = structural_similarity(a.view(), b.view(), everywhere.view());
    EXPECT_DOUBLE_EQ(all.masked.sum, all.all.sum);
    const Similarity single = structural_similarity(a.view(), b.view(), one.view());
    EXPECT_EQ(single.masked.windows, 3);
    ByteImage patch_a(11, 11, 3), patch_b(11, 11, 3);
    for (int y = 0; y < 11; ++y)
        for (int x = 0; x < 11; ++x)
            for (int c = 0; c < 3; ++c) {
                patch_a.pixel(x, y)[c] = a.pixel(x + 15, y + 8)[c];
                patch_b.pixel(x, y)[c] = b.pixel(x + 15, y + 8)[c];
            }
    EXPECT_NEAR(single.masked.mean(), plain_similarity(patch_a, patch_b), 2e-5);
}

}  // namespace
}  // namespace equistream
