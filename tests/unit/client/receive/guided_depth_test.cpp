/// Halved depth told apart by the colour: silhouettes as the colour has them, slopes as they were, no depth made up.
#include <client/receive/decoded_pictures.h>

#include <equistream/bound.h>
#include <equistream/depth_code.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <set>

namespace equistream {
namespace {

constexpr int width = 96, height = 64;
const DepthAgreement agreement{0.0945f, float(std::sin(error_budget_rad(default_focal_length_px)))};

struct Picture {
    FloatImage depth_m{width, height, 1, 6.0f};
    ByteImage luma{width, height, 1, std::uint8_t{50}};

    void draw(int x, int y, float r, int value) {
        *depth_m.pixel(x, y) = r;
        *luma.pixel(x, y) = std::uint8_t(value);
    }
    FloatImage repeated() const { return double_depth(halve_depth(depth_m.view()).view()); }
    FloatImage guided(bool closes = false) const {
        const FloatImage sent_m = repeated();
        return guided_depth(sent_m.view(), luma.view(), agreement, closes);
    }
    int wrong(const FloatImage& found_m) const {
        int count = 0;
        for (std::size_t i = 0; i < found_m.samples().size(); ++i)
            count += found_m.samples()[i] != depth_m.samples()[i];
        return count;
    }
};

TEST(GuidedDepth, AStraightSilhouetteIsWhereItsColourEnds) {
    // From an odd column on, so that squares of four hold both.
    for (const bool across : {false, true}) {
        Picture picture;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                if ((across ? y : x) >= 31)
                    picture.draw(x, y, 1.0f, 200);
        EXPECT_EQ(picture.wrong(picture.repeated()), across ? width : height);
        EXPECT_EQ(picture.wrong(picture.guided()), 0);
    }
}

TEST(GuidedDepth, ADiscKeepsItsOutline) {
    Picture picture;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (std::hypot(x - 40.5, y - 30.5) < 17.3)
                picture.draw(x, y, 1.5f, 180);
    const int without = picture.wrong(picture.repeated());
    EXPECT_GT(without, 50);
    EXPECT_LT(picture.wrong(picture.guided()) * 4, without);
}

TEST(GuidedDepth, ColourAloneMakesNoEdges) {
    // A tilted wall, 1/r linear across it, under noise: its steps are no edges.
    Picture picture;
    std::mt19937 random(3);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            picture.draw(x, y, 1 / (0.2f + 0.005f * float(x) + 0.002f * float(y)), int(16 + random() % 220));
    EXPECT_EQ(picture.wrong(picture.guided()), picture.wrong(picture.repeated()));
}

TEST(GuidedDepth, WithoutColourNothingChanges) {
    Picture picture;
    std::mt19937 random(4);
    for (float& r : picture.depth_m.samples())
        r = 0.5f + float(random() % 100) / 10;
    const FloatImage guided_m = picture.guided(), repeated_m = picture.repeated();
    EXPECT_TRUE(std::ranges::equal(guided_m.samples(), repeated_m.samples()));
}

TEST(GuidedDepth, OnlyNeighbouringDepthsAreGiven) {
    Picture picture;
    std::mt19937 random(6);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            picture.draw(x, y, 0.5f + float(random() % 100000) / 1000, int(16 + random() % 220));
    const FloatImage sent_m = picture.repeated(), guided_m = picture.guided(true);
    int changed = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            std::set<float> near;
            for (int dy = -1; dy <= 1; ++dy)
                for (int dx = -1; dx <= 1; ++dx)
                    near.insert(*sent_m.pixel((x + dx + width) % width, std::clamp(y + dy, 0, height - 1)));
            EXPECT_TRUE(near.contains(*guided_m.pixel(x, y))) << x << ", " << y;
            changed += *guided_m.pixel(x, y) != *sent_m.pixel(x, y);
        }
    EXPECT_GT(changed, width * height / 4);
}

TEST(GuidedDepth, AFullSphereClosesAtItsSeam) {
    // The last column is the one half of what goes on in the first; only across the seam is there more of the wall.
    Picture picture;
    for (int y = 0; y < height; ++y) {
        picture.draw(width - 2, y, 1.0f, 200);
        for (int x = 0; x < width - 2; ++x)
            picture.draw(x, y, 6.0f, x < 4 ? 50 : 120);
        picture.draw(width - 1, y, 6.0f, 50);
    }
    const FloatImage open_m = picture.guided(false), closed_m = picture.guided(true);
    for (int y = 0; y < height; ++y) {
        EXPECT_EQ(*closed_m.pixel(width - 1, y), 6.0f) << y;
        EXPECT_EQ(*open_m.pixel(width - 1, y), 1.0f) << y;
    }
}

TEST(GuidedDepth, LumaOfRgbIsTheStreams) {
    ByteImage rgb(2, 1, 3);
    std::ranges::fill(std::span(rgb.pixel(1, 0), 3), std::uint8_t{255});
    const ByteImage luma = luma_of(rgb.view());
    EXPECT_EQ(*luma.pixel(0, 0), 16);
    EXPECT_EQ(*luma.pixel(1, 0), 235);
    ByteImage primaries(3, 1, 3);
    for (int i = 0; i < 3; ++i)
        primaries.pixel(i, 0)[i] = 255;
    const ByteImage of_primaries = luma_of(primaries.view());
    for (const auto& [x, expected] : {std::pair{0, 63}, {1, 173}, {2, 32}})  // 16 + 219 (0.2126, 0.7152, 0.0722)
        EXPECT_EQ(*of_primaries.pixel(x, 0), expected);
}

}  // namespace
}  // namespace equistream
