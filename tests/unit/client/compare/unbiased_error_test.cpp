#include <client/compare/unbiased_error.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace equistream {
namespace {

constexpr int width = 192;
constexpr int height = 96;

using Generator = std::mt19937;
/// Makes one picture of zero-mean noise.
using Noise = std::function<FloatImage(Generator&)>;

/// What a system does to the picture: wrong all over, and much more so along a silhouette, as at a disocclusion.
FloatImage true_error() {
    FloatImage error(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                error.pixel(x, y)[c] =
                    0.01f * std::sin(0.3f * static_cast<float>(x + 2 * c)) + (std::abs(x - 2 * y) < 6 ? 0.3f : 0.f);
    return error;
}

double mean_square(const FloatImage& image) {
    double sum = 0;
    for (const float value : image.samples())
        sum += static_cast<double>(value) * value;
    return sum / static_cast<double>(image.samples().size());
}

FloatImage sum_of(const FloatImage& a, const FloatImage& b) {
    FloatImage sum = a;
    for (std::size_t i = 0; i < sum.samples().size(); ++i)
        sum.samples()[i] += b.samples()[i];
    return sum;
}

FloatImage gaussian_noise(Generator& generator) {
    std::normal_distribution<float> value(0, 0.06f);
    FloatImage noise(width, height, 3);
    for (float& sample : noise.samples())
        sample = value(generator);
    return noise;
}

/// What a codec leaves of noise: smeared over 8x8 blocks.
FloatImage smeared_noise(Generator& generator) {
    std::normal_distribution<float> value(0, 0.03f);
    FloatImage noise(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                noise.pixel(x, y)[c] =
                    x % 8 == 0 && y % 8 == 0 ? value(generator) : noise.pixel(x / 8 * 8, y / 8 * 8)[c];
    return noise;
}

/// A path tracer's: mostly a little too dark, sometimes far too bright.
FloatImage skewed_noise(Generator& generator) {
    std::exponential_distribution<float> value(1);
    FloatImage noise(width, height, 3);
    for (float& sample : noise.samples()) {
        const float drawn = value(generator);
        sample = 0.02f * (drawn * drawn - 2);
    }
    return noise;
}

struct Coverage {
    double inside = 0;          ///< fraction of runs whose interval holds the true value
    double mean = 0;            ///< of the estimates
    double standard_error = 0;  ///< of that mean
};

/// Many experiments: `shared` noise is in both a run's picture and its truth, as when the source is the truth's own
/// render; each has noise of its own besides.
Coverage cover(const FloatImage& error, const Noise& noise, bool shared) {
    constexpr int runs = 250;
    const FloatImage scene(width, height, 3, 0.4f);
    const double expected = mean_square(error);
    Coverage coverage;
    double square = 0;
    int inside = 0;
    Generator generator(20240607);
    for (int run = 0; run < runs; ++run) {
        FloatImage picture[2], truth[2];
        for (int k = 0; k < 2; ++k) {
            truth[k] = sum_of(scene, noise(generator));
            picture[k] = sum_of(sum_of(scene, error), noise(generator));
            if (shared)
                picture[k] = sum_of(sum_of(truth[k], error), noise(generator));
        }
        const UnbiasedError result =
            unbiased_error(product_blocks({picture[0].view(), truth[0].view()}, {picture[1].view(), truth[1].view()}));
        inside += result.low <= expected && expected <= result.high ? 1 : 0;
        coverage.mean += result.mean_square / runs;
        square += result.mean_square * result.mean_square / runs;
    }
    coverage.inside = static_cast<double>(inside) / runs;
    coverage.standard_error = std::sqrt((square - coverage.mean * coverage.mean) / runs);
    return coverage;
}

void expect_covered(const Noise& noise, double least, double most) {
    for (const bool shared : {false, true}) {
        const FloatImage error = true_error();
        const Coverage coverage = cover(error, noise, shared);
        EXPECT_GE(coverage.inside, least);
        EXPECT_LE(coverage.inside, most);
        EXPECT_NEAR(coverage.mean, mean_square(error), 4 * coverage.standard_error) << "biased";
    }
}

// 250 runs of a true 95 % leave 90.9 % to 99.1 % at three standard deviations.
TEST(NoiseFree, IntervalCoversTheTrueErrorUnderGaussianNoise) {
    expect_covered(gaussian_noise, 0.909, 0.991);
}
TEST(NoiseFree, IntervalCoversTheTrueErrorUnderSmearedNoise) {
    expect_covered(smeared_noise, 0.909, 0.991);
}
TEST(NoiseFree, IntervalErrsOnTheWideSideUnderSkewedNoise) {
    expect_covered(skewed_noise, 0.909, 1);
}

TEST(NoiseFree, AnErrorFarBelowTheNoiseIsFound) {
    FloatImage error(width, height, 3, 0.01f);  // 40 dB, under noise of 0.085 between picture and truth: 21 dB
    Generator generator(7);
    ProductBlocks blocks;
    for (int frame = 0; frame < 8; ++frame) {
        FloatImage picture[2], truth[2];
        for (int k = 0; k < 2; ++k) {
            truth[k] = gaussian_noise(generator);
            picture[k] = sum_of(error, gaussian_noise(generator));
        }
        blocks.add(product_blocks({picture[0].view(), truth[0].view()}, {picture[1].view(), truth[1].view()}));
    }
    const UnbiasedError result = unbiased_error(blocks);
    EXPECT_FALSE(result.only_bounded());
    EXPECT_NEAR(UnbiasedError::decibels(result.mean_square), 40, 1);
    EXPECT_EQ(result.samples, std::int64_t{8} * 3 * width * height);
    EXPECT_EQ(result.blocks, 6 * 3);
}

TEST(NoiseFree, NoErrorIsOnlyBounded) {
    Generator generator(8);
    int bounded = 0;
    for (int run = 0; run < 100; ++run) {
        FloatImage images[4];
        for (FloatImage& image : images)
            image = gaussian_noise(generator);
        const UnbiasedError result =
            unbiased_error(product_blocks({images[0].view(), images[1].view()}, {images[2].view(), images[3].view()}));
        bounded += result.only_bounded() ? 1 : 0;
        EXPECT_GT(result.high, result.mean_square);
    }
    EXPECT_GE(bounded, 92);  // one-sided 97.5 %
}

TEST(NoiseFree, AMaskLeavesTheOtherPixelsOut) {
    FloatImage truth(width, height, 3, 0.25f);
    FloatImage picture = truth;
    ByteImage mask(width, height, 1);
    std::int64_t inside = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool masked = (x * 7 + y * 3) % 5 == 0;
            *mask.pixel(x, y) = masked ? 255 : 0;
            inside += masked ? 1 : 0;
            std::fill_n(picture.pixel(x, y), 3, masked ? 0.5f : 1.0f);
        }
    const PictureAndTruth run{picture.view(), truth.view()};
    const UnbiasedError result = unbiased_error(product_blocks(run, run, mask.view()));
    EXPECT_EQ(result.samples, 3 * inside);
    EXPECT_NEAR(result.mean_square, 0.0625, 1e-9);
}

TEST(NoiseFree, WorstPixelsWithoutNoiseAreTheWorstPixels) {
    // 192 x 96: the worst hundredth is 185 pixels; their square errors are 18432, 18431, ... 18248 of 18432.
    constexpr int all = width * height;
    const FloatImage truth(width, height, 3);
    FloatImage picture(width, height, 3);
    double sum = 0;
    for (int i = 0; i < all; ++i) {
        const int rank = (i * 5003) % all;  // a permutation: 5003 is prime
        const float error = std::sqrt(static_cast<float>(rank + 1) / all);
        std::fill_n(picture.pixel(i % width, i / width), 3, i % 2 == 0 ? error : -error);
    }
    for (int rank = all - 185; rank < all; ++rank)
        sum += (rank + 1.0) / all;
    const PictureAndTruth run{picture.view(), truth.view()};
    const UnbiasedError worst = unbiased_error(worst_product_blocks(run, run, 0.01));
    EXPECT_EQ(worst.samples, 2 * 3 * 185);
    EXPECT_NEAR(worst.mean_square, sum / 185, 1e-6);
    EXPECT_NEAR(worst.high, worst.mean_square, 1e-6);
    const FloatImage even(width, height, 3, 0.5f);
    const PictureAndTruth flat{even.view(), truth.view()};
    EXPECT_EQ(unbiased_error(worst_product_blocks(flat, flat, 0.01)).samples, 2 * 3 * 185) << "equals";
}

/// Gray noise on an error of `error` everywhere: D is N(error, deviation^2), all channels alike.
UnbiasedError worst_of_gray_noise(float error, float deviation, unsigned seed) {
    Generator generator(seed);
    std::normal_distribution<float> value(0, deviation);
    const FloatImage truth(width, height, 3);
    ProductBlocks blocks;
    for (int frame = 0; frame < 40; ++frame) {
        FloatImage picture[2] = {FloatImage(width, height, 3), FloatImage(width, height, 3)};
        for (FloatImage& image : picture)
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    std::fill_n(image.pixel(x, y), 3, error + value(generator));
        blocks.add(worst_product_blocks({picture[0].view(), truth.view()}, {picture[1].view(), truth.view()}, 0.01));
    }
    return unbiased_error(blocks);
}

TEST(NoiseFree, WorstPixelsUnderNoiseScoreTheirErrorAndNotTheNoise) {
    EXPECT_TRUE(worst_of_gray_noise(0, 0.1f, 31).only_bounded()) << "PSNR would say 11 dB";
    // Of X = N(e, s^2) chosen where |X| > t: E[X; chosen] = e P + s (phi(a) - phi(b)), a = (t - e)/s, b = (-t - e)/s.
    const double e = 0.1, s = 0.05;
    const auto tail = [](double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); };
    const auto density = [](double z) { return std::exp(-z * z / 2) / std::sqrt(2 * std::acos(-1.0)); };
    double low = 0, high = 1;
    for (int step = 0; step < 60; ++step) {
        const double t = (low + high) / 2;
        (tail((t - e) / s) + tail((t + e) / s) > 0.01 ? low : high) = t;
    }
    const double a = (low - e) / s, b = (-low - e) / s;
    const double chosen = e + s * (density(a) - density(b)) / 0.01;
    const UnbiasedError worst = worst_of_gray_noise(0.1f, 0.05f, 32);
    // 40 x 2 x 185 products of a spread of about chosen x s (the threshold is each frame's own): 1.5 % at four sigmas.
    EXPECT_NEAR(worst.mean_square, e * chosen, 0.015 * e * chosen);
    EXPECT_LE(worst.low, e * chosen);
    EXPECT_GE(worst.high, e * chosen);
}

/// A picture with an error and noise of its own, against two truths that are noisier still.
struct AgainstTwoTruths {
    explicit AgainstTwoTruths(Generator& generator)
        : picture(sum_of(sum_of(scene, true_error()), smeared_noise(generator))),
          second_picture(sum_of(sum_of(scene, true_error()), smeared_noise(generator))),
          truth(sum_of(scene, gaussian_noise(generator))), second_truth(sum_of(scene, gaussian_noise(generator))) {}

    UnbiasedError whole() const {
        return unbiased_error(product_blocks({picture.view(), truth.view()}, {picture.view(), second_truth.view()}));
    }
    UnbiasedError noise_free() const {
        return unbiased_error(
            product_blocks({picture.view(), truth.view()}, {second_picture.view(), second_truth.view()}));
    }

    FloatImage scene{width, height, 3, 0.4f};
    FloatImage picture, second_picture, truth, second_truth;
};

TEST(WholeError, CountsThePicturesNoiseAndNotTheTruths) {
    Generator generator(41);
    double whole = 0, noise_free = 0;
    int inside = 0;
    constexpr int runs = 250;
    for (int run = 0; run < runs; ++run) {
        const AgainstTwoTruths made(generator);
        double of_this_picture = 0;
        for (std::size_t i = 0; i < made.picture.samples().size(); ++i)
            of_this_picture += std::pow(static_cast<double>(made.picture.samples()[i]) - 0.4, 2);
        of_this_picture /= 3 * width * height;
        const UnbiasedError error = made.whole();
        inside += error.low <= of_this_picture && of_this_picture <= error.high ? 1 : 0;
        whole += error.mean_square / runs;
        noise_free += made.noise_free().mean_square / runs;
    }
    EXPECT_GE(inside, 0.909 * runs) << "the interval is that of the truths' noise, for this very picture";
    EXPECT_LE(inside, 0.991 * runs);
    const double bias = mean_square(true_error()), noise = 0.03 * 0.03;
    // Four standard errors, most of them of smeared noise times the error.
    EXPECT_NEAR(whole, bias + noise, 4e-5);
    EXPECT_NEAR(noise_free, bias, 4e-5);
}

TEST(WholeError, ADenoiserThatBlursLittleGainsMuch) {
    Generator generator(42);
    const FloatImage scene(width, height, 3, 0.4f);
    const auto truth = [&] { return sum_of(scene, gaussian_noise(generator)); };
    const FloatImage truths[2] = {truth(), truth()}, noisy[2] = {truth(), truth()};
    const FloatImage denoised(width, height, 3, 0.42f);
    const auto error = [&](const FloatImage& a, const FloatImage& a2) {
        return unbiased_error(product_blocks({a.view(), truths[0].view()}, {a2.view(), truths[1].view()})).mean_square;
    };
    EXPECT_GT(error(noisy[0], noisy[0]), 5 * error(denoised, denoised)) << "whole";
    EXPECT_LT(error(noisy[0], noisy[1]), error(denoised, denoised)) << "noise-free: its bias counts, its gain does not";
}

TEST(NoiseFree, IdenticalPicturesHaveNoErrorAndNoSpread) {
    const FloatImage image(40, 40, 3, 0.5f);
    const UnbiasedError result =
        unbiased_error(product_blocks({image.view(), image.view()}, {image.view(), image.view()}));
    EXPECT_EQ(result.mean_square, 0);
    EXPECT_EQ(result.high, 0);
}

}  // namespace
}  // namespace equistream
