#include "synthetic.h"

#include <equistream/visible_loss.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>
#include <span>

namespace equistream {
namespace {

constexpr int width = 96, height = 64;

/// Grey, with a checkerboard of single pixels whose squares differ by `contrast`.
ByteImage checkerboard(int contrast) {
    ByteImage picture(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            std::fill_n(picture.pixel(x, y), 3, std::uint8_t(100 + (x + y) % 2 * contrast));
    return picture;
}

float texture_of(int contrast) {
    return std::log2(1 + 0.5f * float(contrast));
}

ByteImage with_errors_of(ByteImage picture, int error) {
    std::mt19937 random(3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            // In any one channel: the worst counts.
            picture.pixel(x, y)[random() % 3] += std::uint8_t(random() % 2 == 0 ? error : -error);
    return picture;
}

TEST(Contrast, IsTheWorstChannelsDifferenceToWhatLiesAround) {
    ByteImage picture(5, 4, 4, 50);
    picture.pixel(2, 1)[1] = 70;
    picture.pixel(2, 1)[3] = 200;  // alpha is none
    picture.pixel(1, 2)[2] = 45;
    const ByteImage contrast = contrast_of(picture.view(), 1);
    constexpr int expected[4][5] = {{0, 0, 0, 0, 0}, {0, 20, 20, 20, 0}, {0, 5, 20, 0, 0}, {0, 0, 0, 0, 0}};
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x)
            EXPECT_EQ(contrast.pixel(x, y)[0], expected[y][x]) << x << " " << y;
    EXPECT_EQ(contrast_of(picture.view(), 2).pixel(2, 1)[0], 20);
    EXPECT_EQ(contrast_of(picture.view(), 3).pixel(2, 1)[0], 0);
}

TEST(VisibleLoss, LiesOnStraightLinesBetweenItsTextures) {
    VisibleLoss loss;
    for (std::size_t i = 0; i < loss.share_255.size(); ++i)
        loss.share_255[i] = std::uint8_t(3 + 37 * i * i % 250);
    for (std::size_t i = 0; i + 1 < loss.share_255.size(); ++i) {
        const float a = VisibleLoss::textures[i], b = VisibleLoss::textures[i + 1];
        const float at_a = loss.share_255[i], at_b = loss.share_255[i + 1];
        EXPECT_NEAR(loss_at(loss, a), at_a / 255, 1e-6);
        EXPECT_NEAR(loss_at(loss, a + 0.25f * (b - a)), (0.75f * at_a + 0.25f * at_b) / 255, 1e-6);
    }
    EXPECT_EQ(loss_at(loss, VisibleLoss::textures.back()), float(loss.share_255.back()) / 255);
    EXPECT_EQ(loss_at(loss, 100), float(loss.share_255.back()) / 255);
}

/// What was taken from a picture in which nothing is left counts where nothing is left, not where it was.
TEST(VisibleLossMeter, CountsByTheTextureOfTheDecodedPicture) {
    VisibleLossMeter meter;
    EXPECT_EQ(meter.loss(), VisibleLoss{});
    const ByteImage flat = checkerboard(0), rich = checkerboard(14);
    ASSERT_EQ(texture_of(14), 3);
    meter.add(with_errors_of(flat, visible_loss_255 + 1).view(), flat.view());
    EXPECT_EQ(loss_at(meter.loss(), 0), 1);
    EXPECT_EQ(loss_at(meter.loss(), 5), 1);  // nothing else was seen
    meter.add(with_errors_of(rich, visible_loss_255 + 1).view(), rich.view());
    for (int i = 0; i < 3; ++i)
        meter.add(with_errors_of(rich, visible_loss_255).view(), rich.view());
    const VisibleLoss loss = meter.loss();
    EXPECT_EQ(loss_at(loss, 0), 1);
    for (const float texture : {2.75f, 3.0f, 3.5f, 4.25f, 6.0f})  // between the first two the pixels are shared out
        EXPECT_NEAR(loss_at(loss, texture), 0.25, 0.5 / 255) << texture;
    EXPECT_EQ(loss_at(loss, 1), 1);  // nearer to 0 than to 2.75
    EXPECT_NEAR(loss_at(loss, 2), 0.25, 0.5 / 255);
}

TEST(VisibleLossMeter, GoesByReferencesWhereThereAreEnough) {
    const ByteImage flat(200, 100, 3, 100);
    ByteImage shown = flat;
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 200; x += 2)
            shown.pixel(x, y)[1] = 115;
    VisibleLossMeter meter;
    meter.add(shown.view(), shown.view());  // coding took nothing
    EXPECT_EQ(meter.loss(), VisibleLoss());
    ByteImage reference(200, 100, 4);
    const auto know = [&](int tiles) {
        for (int tile = 0; tile < tiles; ++tile)
            for (int i = 0; i < 16; ++i)
                std::ranges::fill(std::span(reference.pixel(4 * tile + i % 4, 40 + i / 4), 4), std::uint8_t{100});
    };
    know(6);
    meter.add_reference(shown.view(), reference.view(), reference.view());
    EXPECT_EQ(meter.loss(), VisibleLoss()) << "96 pixels are too few";
    reference = ByteImage(200, 100, 4);
    know(40);
    meter = {};
    meter.add(shown.view(), shown.view());
    meter.add_reference(shown.view(), reference.view(), reference.view());
    for (const std::uint8_t share : meter.loss().share_255)
        EXPECT_NEAR(share, 127.5, 1) << "every second pixel is off by 15";
}

TEST(VisibleLossMeter, IsOffOnlyBesideBothReferencesAndToOneSide) {
    const ByteImage shown(200, 100, 3, 100);
    const auto share = [&](std::uint8_t first, std::uint8_t second) {
        const ByteImage reference(200, 100, 4, first), repeat(200, 100, 3, second);
        VisibleLossMeter meter;
        meter.add_reference(shown.view(), reference.view(), repeat.view());
        return loss_at(meter.loss(), 0);
    };
    EXPECT_EQ(share(111, 130), 1);
    EXPECT_EQ(share(89, 70), 1);
    EXPECT_EQ(share(110, 130), 0) << "beside one reference alone it is off";
    EXPECT_EQ(share(90, 70), 0);
    EXPECT_EQ(share(60, 140), 0) << "it lies between both: they are noisy";
}

TEST(VisibleLossMeter, GoesByCodingTooWhereATextureHasTooFewReferences) {
    // Left: flat, as it should be. Right: rich, where coding took half; the references lie on the left.
    ByteImage picture(200, 100, 3, 100), shown(200, 100, 3, 100);
    for (int y = 0; y < 100; ++y)
        for (int x = 100; x < 200; ++x) {
            std::fill_n(shown.pixel(x, y), 3, std::uint8_t(100 + (x + y) % 2 * 40));
            std::fill_n(picture.pixel(x, y), 3, std::uint8_t(100 + (x + y) % 2 * 40 + (x / 2 % 2) * 20));
        }
    ByteImage reference(200, 100, 4);
    for (int y = 0; y < 100; ++y)
        for (int x = 0; x < 60; ++x)
            std::ranges::fill(std::span(reference.pixel(x, y), 4), std::uint8_t{100});
    VisibleLossMeter meter;
    meter.add(picture.view(), shown.view());
    meter.add_reference(shown.view(), reference.view(), reference.view());
    EXPECT_EQ(loss_at(meter.loss(), 0), 0);
    EXPECT_NEAR(loss_at(meter.loss(), 4.25f), 0.5, 0.06);
}

/// A handful of pixels at an edge is no measurement.
TEST(VisibleLossMeter, TexturesThatHardlyAnyPixelShowsHaveTheNearestOnesLoss) {
    ByteImage flat = checkerboard(0);
    std::fill_n(flat.pixel(0, 0), 3, std::uint8_t{255});  // within 9x9 pixels: texture up to 2
    VisibleLossMeter meter;
    meter.add(with_errors_of(flat, 0).view(), flat.view());
    ByteImage off = flat;
    for (int y = 0; y < 5; ++y)
        for (int x = 0; x < 5; ++x)
            off.pixel(x, y)[1] += 50;
    meter.add(off.view(), flat.view());
    EXPECT_LT(loss_at(meter.loss(), 2), 0.02);
}

/// The usual loss grows with the CRF and with texture.
TEST(VisibleLoss, UsualOnesGrowWithTheCrf) {
    for (const float texture : VisibleLoss::textures) {
        float before = 0;
        for (const double crf : {0.0, 8.0, 16.0, 24.0, 32.0, 40.0, 51.0}) {
            const float loss = loss_at(usual_coding_loss(crf), texture);
            EXPECT_GE(loss, before) << crf << " " << texture;
            before = loss;
        }
        EXPECT_GT(before, 0.2) << texture;
    }
    EXPECT_EQ(loss_at(usual_coding_loss(16), 0), 0);
    EXPECT_GT(loss_at(usual_coding_loss(16), 5), 0.3);
}

double share_off(const ByteImage& a, const ByteImage& b) {
    int off = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto is_off = [](int i, int j) { return std::abs(i - j) > visible_loss_255; };
            off += !std::equal(a.pixel(x, y), a.pixel(x, y) + 3, b.pixel(x, y), std::not_fn(is_off));
        }
    return off / double(width * height);
}

/// Fine noise is gone from what a coarse quantiser leaves, and both pictures together say so.
TEST(VisibleLossMeter, FindsWhatACodecTook) {
    ByteImage noise = checkerboard(0);
    std::mt19937 random(5);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            std::fill_n(noise.pixel(x, y), 3, std::uint8_t(80 + random() % 41));
    synthetic::Folder folder;
    VisibleLoss losses[2];
    double off[2];
    for (const bool coarse : {false, true}) {
        StreamSettings settings;
        settings.crf = coarse ? 44 : 4;
        settings.tracks = {{TrackRole::main, width, height}};
        settings.pictures = 1;
        const std::string file = (folder / (coarse ? "coarse.nut" : "fine.nut")).string();
        StreamWriter writer(file, settings);
        writer.write(TrackRole::main, noise.view(), synthetic::info(width, height, 0));
        writer.finish();
        StreamReader reader(file);
        const auto decoded = reader.next();
        ASSERT_TRUE(decoded);
        VisibleLossMeter meter;
        meter.add(noise.view(), decoded->rgb.view());
        losses[int(coarse)] = meter.loss();
        off[int(coarse)] = share_off(noise, decoded->rgb);
    }
    EXPECT_GT(off[1], 0.4);
    EXPECT_NEAR(loss_at(losses[1], 0), off[1], 0.1);  // most of it is flat
    EXPECT_LT(off[0], 0.1);
    EXPECT_NEAR(loss_at(losses[0], 3.5f), off[0], 0.02);
}

}  // namespace
}  // namespace equistream
