#include "evidence.h"

#include <equistream/picture.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

/// The three pictures that a line of evidence speaks of; they are removed.
struct Found {
    ByteImage image, reference, difference;

    explicit Found(const std::string& line) {
        const std::string pattern = line.substr(line.find(" are in ") + 8);
        const auto take = [&](const std::string& what) {
            const fs::path file = pattern.substr(0, pattern.size() - 5) + what + ".png";
            const ByteImage picture = read_picture(file);
            fs::remove(file);
            return picture;
        };
        image = take("image");
        reference = take("reference");
        difference = take("difference");
    }
};

TEST(Evidence, PicturesAreWhatTheyWereAndTheLargestDifferenceIsWhite) {
    ByteImage a(3, 2, 3, 100), b = a;
    a.pixel(1, 1)[2] = 110;
    a.pixel(2, 0)[0] = 95;
    const Found found(evidence(a.view(), b.view()));
    EXPECT_EQ(found.image.pixel(1, 1)[2], 110);
    EXPECT_EQ(found.reference.pixel(1, 1)[2], 100);
    EXPECT_EQ(found.difference.pixel(1, 1)[2], 255);
    EXPECT_NEAR(found.difference.pixel(2, 0)[0], 127, 1);
    EXPECT_EQ(found.difference.pixel(0, 0)[0], 0);
}

TEST(Evidence, DepthsAreScaledAndAMissAgainstAHitIsWhite) {
    constexpr float infinite = std::numeric_limits<float>::infinity();
    FloatImage a(4, 1, 1, 8.0f), b(4, 1, 1, 8.0f);
    a.pixel(0, 0)[0] = infinite;
    a.pixel(1, 0)[0] = b.pixel(1, 0)[0] = infinite;
    a.pixel(2, 0)[0] = 4;
    const Found found(evidence(a.view(), b.view()));
    EXPECT_EQ(found.reference.pixel(0, 0)[0], 255);
    EXPECT_EQ(found.image.pixel(2, 0)[0], 128);
    EXPECT_EQ(found.difference.pixel(0, 0)[0], 255);
    EXPECT_EQ(found.difference.pixel(1, 0)[0], 0);
    EXPECT_EQ(found.difference.pixel(2, 0)[0], 255);
    EXPECT_EQ(found.difference.pixel(3, 0)[0], 0);
}

TEST(Evidence, OtherShapesAreSaidToBe) {
    const FloatImage a(4, 1, 1), b(4, 2, 1);
    EXPECT_NE(evidence(a.view(), b.view()).find("shape"), std::string::npos);
}

}  // namespace
}  // namespace equistream::test
