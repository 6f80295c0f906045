#include <equistream/error.h>
#include <equistream/picture.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace equistream {
namespace {

namespace fs = std::filesystem;

ByteImage gradient(int channels) {
    ByteImage picture(37, 19, channels);
    std::uint8_t value = 3;
    for (std::uint8_t& sample : picture.samples())
        sample = value = static_cast<std::uint8_t>(value * 5 + 1);
    return picture;
}

TEST(PictureFile, PngKeepsEveryByte) {
    const fs::path file = fs::path(testing::TempDir()) / "picture.png";
    for (const int channels : {1, 3}) {
        const ByteImage written = gradient(channels);
        write_picture(file, written.view());
        const ByteImage read = read_picture(file);
        ASSERT_EQ(read.channels(), channels);
        EXPECT_TRUE(std::ranges::equal(written.samples(), read.samples()));
    }
}

TEST(PictureFile, TruncationIsAnErrorThatNamesTheFile) {
    const fs::path file = fs::path(testing::TempDir()) / "cut.png";
    write_picture(file, gradient(3).view());
    const auto size = fs::file_size(file);
    for (const double share : {0.0, 0.1, 0.5, 0.9}) {
        write_picture(file, gradient(3).view());
        fs::resize_file(file, static_cast<std::uintmax_t>(static_cast<double>(size) * share));
        try {
            read_picture(file);
            FAIL() << "read a picture cut to " << share;
        } catch (const InputError& e) {
            EXPECT_NE(std::string(e.what()).find("cut.png"), std::string::npos);
        }
    }
    EXPECT_THROW(read_picture(fs::path(testing::TempDir()) / "none.png"), InputError);
}

std::string error_of_reading(const fs::path& file) {
    try {
        read_picture(file);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

TEST(PictureFile, DamageAnywhereIsOneErrorAndLibpngStaysSilent) {
    const fs::path file = fs::path(testing::TempDir()) / "damaged.png";
    write_picture(file, gradient(3).view());
    std::ifstream in(file, std::ios::binary);
    const std::string whole{std::istreambuf_iterator<char>(in), {}};
    testing::internal::CaptureStderr();
    for (std::size_t at = 8; at < whole.size(); ++at) {  // behind the signature
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        std::ofstream(file, std::ios::binary) << damaged;
        EXPECT_NE(error_of_reading(file).find("damaged.png: expected a whole PNG picture"), std::string::npos) << at;
        std::ofstream(file, std::ios::binary) << whole.substr(0, at);
        EXPECT_NE(error_of_reading(file).find("damaged.png: expected a whole PNG picture"), std::string::npos) << at;
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    std::string damaged = whole;
    char& within = damaged[damaged.find("IDAT") + 9];
    within = static_cast<char>(within ^ 1);
    std::ofstream(file, std::ios::binary) << damaged;
    EXPECT_EQ(error_of_reading(file), file.string() + ": expected a whole PNG picture, found a damaged chunk IDAT");
}

TEST(PictureFile, AnUnwritableFolderIsAWorkErrorAndLeavesNothing) {
    EXPECT_THROW(write_picture("/proc/picture.png", gradient(3).view()), WorkError);
}

class FalseColour : public testing::Test {
protected:
    FalseColour() {
        frame.info.camera = EquirectCamera{4, 2, {}};
        FloatImage depth(4, 2, 1, 5.0f);
        *depth.pixel(0, 0) = std::numeric_limits<float>::infinity();
        *depth.pixel(1, 0) = 1.0f;
        *depth.pixel(2, 0) = 100.0f;
        frame.planes["depth"] = std::move(depth);
        FloatImage motion(4, 2, 2, 0.0f);
        motion.pixel(1, 1)[0] = 1.0f;
        motion.pixel(2, 1)[0] = -1.0f;
        frame.planes["backward"] = std::move(motion);
        FloatImage normal(4, 2, 3, 0.0f);
        normal.pixel(0, 0)[1] = 1.0f;
        frame.planes["normal"] = std::move(normal);
        FloatImage specular(4, 2, 1, 0.0f);
        *specular.pixel(3, 1) = 1.0f;
        frame.planes["specular"] = std::move(specular);
        IdImage ids(4, 2, 1, 0);
        *ids.pixel(1, 0) = 1;
        *ids.pixel(2, 0) = 2;
        frame.ids["object_id"] = std::move(ids);
    }
    Frame frame;
    DisplayTransform display;
};

int brightness(const std::uint8_t* rgb) {
    return std::max({rgb[0], rgb[1], rgb[2]});
}

TEST_F(FalseColour, MirrorsAreWhite) {
    const ByteImage picture = picture_of_plane(frame, "specular", display);
    EXPECT_EQ(brightness(picture.pixel(0, 0)), 0);
    EXPECT_EQ(brightness(picture.pixel(3, 1)), 255);
}

TEST_F(FalseColour, WhatMirrorsShowLooksLikeDepthAndMotion) {
    frame.planes["virtual_depth"] = frame.planes["depth"];
    frame.planes["virtual_forward"] = frame.planes["backward"];
    for (const auto& [plane, like] : {std::pair("virtual_depth", "depth"), {"virtual_forward", "backward"}})
        EXPECT_TRUE(std::ranges::equal(picture_of_plane(frame, plane, display).samples(),
                                       picture_of_plane(frame, like, display).samples()))
            << plane;
}

TEST_F(FalseColour, WhereAHiddenLayerHasNothingItIsBlack) {
    *frame.planes["depth"].pixel(1, 0) = std::nanf("");
    EXPECT_EQ(brightness(picture_of_plane(frame, "depth", display).pixel(1, 0)), 0);
}

TEST_F(FalseColour, NearIsBrighterThanFarAndMissesAreBlack) {
    for (const double ipd_m : {0.063, 0.0}) {  // 0 without a lean: a head box of radius 0
        frame.info.ipd_m = ipd_m;
        const ByteImage picture = picture_of_plane(frame, "depth", display);
        EXPECT_EQ(brightness(picture.pixel(0, 0)), 0);
        EXPECT_GT(brightness(picture.pixel(1, 0)), brightness(picture.pixel(3, 0)));
        EXPECT_GT(brightness(picture.pixel(3, 0)), brightness(picture.pixel(2, 0)));
        EXPECT_GT(brightness(picture.pixel(2, 0)), 0);
    }
}

TEST_F(FalseColour, OppositeMotionsHaveOppositeHuesAndNoneIsBlack) {
    const ByteImage picture = picture_of_plane(frame, "backward", display);
    EXPECT_EQ(brightness(picture.pixel(0, 0)), 0);
    EXPECT_EQ(brightness(picture.pixel(1, 1)), 255);
    EXPECT_NE(*picture.pixel(1, 1), *picture.pixel(2, 1));
}

TEST_F(FalseColour, NormalsPointUpInGreenAndIdsDiffer) {
    EXPECT_EQ(picture_of_plane(frame, "normal", display).pixel(0, 0)[1], 255);
    const ByteImage ids = picture_of_plane(frame, "object_id", display);
    EXPECT_EQ(brightness(ids.pixel(0, 0)), 0);
    EXPECT_FALSE(std::equal(ids.pixel(1, 0), ids.pixel(1, 0) + 3, ids.pixel(2, 0)));
}

TEST_F(FalseColour, AMissingPlaneIsNamed) {
    EXPECT_THROW(picture_of_plane(frame, "albedo", display), InputError);
}

}  // namespace
}  // namespace equistream
