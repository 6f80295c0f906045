/// HDR streams: 10-bit planes by their formula, and what comes back of light brighter than white.
#include "synthetic.h"

#include <equistream/colour.h>
#include <equistream/error.h>
#include <equistream/yuv.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace equistream {
namespace {

struct Planes {
    Planes(int width, int height) : y(width, height, 1), cb(width / 2, height / 2, 1), cr(width / 2, height / 2, 1) {}
    Yuv420View<std::uint16_t> view() { return {y.view(), cb.view(), cr.view()}; }
    PqView const_view() const { return {y.view(), cb.view(), cr.view()}; }
    Image<std::uint16_t> y, cb, cr;
};

FloatImage random_colours(int width, int height) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> value(0, 1);
    FloatImage image(width, height, 3);
    for (float& sample : image.samples())
        sample = value(generator);
    return image;
}

/// BT.2020's constants, written down once more.
double luma(const float* rgb) {
    return 0.2627 * double(rgb[0]) + 0.6780 * double(rgb[1]) + 0.0593 * double(rgb[2]);
}

TEST(Pq420, DownIsTheFormula) {
    const FloatImage rgb = random_colours(70, 46);
    Planes planes(70, 46);
    rgb_to_pq(rgb.view(), planes.view());
    for (int y = 0; y < 46; ++y)
        for (int x = 0; x < 70; ++x)
            EXPECT_NEAR(*planes.y.pixel(x, y), 64 + 876 * luma(rgb.pixel(x, y)), 0.51);
    for (int j = 0; j < 23; ++j)
        for (int i = 0; i < 35; ++i) {
            double cb = 0, cr = 0;
            for (int dy = 0; dy < 2; ++dy)
                for (int dx = -1; dx <= 1; ++dx) {
                    const float* p = rgb.pixel(std::max(2 * i + dx, 0), 2 * j + dy);
                    const double weight = dx == 0 ? 0.25 : 0.125;
                    cb += weight * (double(p[2]) - luma(p)) / 1.8814;
                    cr += weight * (double(p[0]) - luma(p)) / 1.4746;
                }
            EXPECT_NEAR(*planes.cb.pixel(i, j), 512 + 896 * cb, 0.51);
            EXPECT_NEAR(*planes.cr.pixel(i, j), 512 + 896 * cr, 0.51);
        }
}

TEST(Pq420, SmoothColoursComeBack) {
    FloatImage rgb(64, 32, 3);
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) {
            rgb.pixel(x, y)[0] = 0.3f + 0.4f * float(x) / 64;
            rgb.pixel(x, y)[1] = 0.6f - 0.3f * float(y) / 32;
            rgb.pixel(x, y)[2] = 0.5f;
        }
    Planes planes(64, 32);
    rgb_to_pq(rgb.view(), planes.view());
    const FloatImage again = pq_to_rgb(planes.const_view());
    for (int y = 1; y < 31; ++y)
        for (int x = 2; x < 62; ++x)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(again.pixel(x, y)[c], rgb.pixel(x, y)[c], 0.0025) << x << ' ' << y << ' ' << c;
}

class HdrStreams : public testing::TestWithParam<Codec> {
protected:
    synthetic::Folder folder;
};

TEST_P(HdrStreams, KeepWhatIsBrighterThanWhite) {
    constexpr int width = 128, height = 64;
    FloatImage light(width, height, 3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                light.pixel(x, y)[c] =
                    std::exp2(-4 + 9 * float(x) / width) * (c == 1 ? 1.0f : 0.7f);  // to 32 times white
    const PqEncoding encoding;
    const FloatImage pq = encoding.encode(light.view(), 1);
    const std::string file = folder / "hdr.mkv";
    StreamSettings settings;
    settings.codec = GetParam();
    settings.transfer = Transfer::pq;
    settings.crf = 4;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, width, height}};
    {
        StreamWriter writer(file, settings);
        for (int i = 0; i < 3; ++i)
            writer.write_pq(TrackRole::main, pq.view(), synthetic::info(width, height, i));
        EXPECT_THROW(
            writer.write(TrackRole::main, ByteImage(width, height, 3).view(), synthetic::info(width, height, 3)),
            WorkError);
        writer.finish();
    }
    StreamReader reader(file, {.pq = true});
    EXPECT_EQ(reader.tracks()[0].colour, "tv/bt2020/smpte2084/bt2020nc");
    int pictures = 0;
    while (const auto picture = reader.next()) {
        ASSERT_FALSE(picture->pq.empty());
        EXPECT_TRUE(picture->rgb.empty());
        const FloatImage decoded = pq_to_rgb(picture->pq.planes);
        double sum = 0;
        for (std::size_t i = 0; i < pq.samples().size(); ++i)
            sum += std::pow(double(decoded.samples()[i]) - double(pq.samples()[i]), 2);
        // A 10-bit step off is 0.0011, of which light moves by 1 %.
        EXPECT_LT(std::sqrt(sum / double(pq.samples().size())), 0.004);
        ++pictures;
    }
    EXPECT_EQ(pictures, 3);
    StreamReader plain(file);
    const auto dull = plain.next();
    ASSERT_TRUE(dull);
    EXPECT_FALSE(dull->rgb.empty()) << "whoever does not ask for PQ gets a picture all the same";
}

INSTANTIATE_TEST_SUITE_P(BothCodecs, HdrStreams, testing::Values(Codec::h264, Codec::h265),
                         [](const auto& one) { return one.param == Codec::h264 ? "h264" : "h265"; });

}  // namespace
}  // namespace equistream
