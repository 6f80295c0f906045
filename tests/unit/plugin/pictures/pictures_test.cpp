#include <plugin/pictures/encoded_image.h>

#include <equistream/error.h>
#include <equistream/picture.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <vector>

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

TEST(PictureFile, AnyPathLeadsToIt) {
    const ByteImage written = gradient(3);
    for (const char* folder : {"what?", "a?b=c", "100%", "[1]", "a b"}) {
        const fs::path file = fs::path(testing::TempDir()) / folder / "picture.png";
        fs::create_directories(file.parent_path());
        write_picture(file, written.view());
        EXPECT_TRUE(std::ranges::equal(written.samples(), read_picture(file).samples())) << folder;
        fs::remove_all(file.parent_path());
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

std::vector<std::uint8_t> bytes_of(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(EncodedImage, SaysItsChannelsAlphaAndFormat) {
    const fs::path file = fs::path(testing::TempDir()) / "encoded.png";
    for (const int channels : {1, 2, 3, 4}) {
        ByteImage written = gradient(channels);
        if (channels % 2 == 0)  // opaque: the PNG writer divides by alpha
            for (int y = 0; y < written.height(); ++y)
                for (int x = 0; x < written.width(); ++x)
                    written.pixel(x, y)[channels - 1] = 255;
        write_picture(file, written.view());
        const std::vector<std::uint8_t> bytes = bytes_of(file);
        EncodedImage image(bytes, "a.png", "scene.gltf");
        EXPECT_EQ(image.width(), 37);
        EXPECT_EQ(image.height(), 19);
        EXPECT_EQ(image.channels(), channels);
        EXPECT_EQ(image.alpha_channel(), channels % 2 == 0 ? channels - 1 : -1);
        EXPECT_TRUE(std::ranges::equal(image.read(), written.samples()));
    }
    EXPECT_STREQ(image_format({}, "x.TGA"), "targa");
    EXPECT_STREQ(image_format({}, ".tga"), "targa");
    EXPECT_EQ(image_format({}, "tga"), nullptr);
    EXPECT_EQ(image_format({}, "x.png"), nullptr);
}

TEST(EncodedImage, RefusesWhatIsCutOrOfNoFormat) {
    const auto refusal = [](const std::vector<std::uint8_t>& bytes) -> std::string {
        try {
            const EncodedImage image(bytes, "a", "scene.gltf");
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(refusal({0xff, 0xd8, 0xff, 0xe0}), "scene.gltf: expected a whole JPEG image, found one without its end");
    EXPECT_NE(refusal({'x', 'y'}).find("found other data"), std::string::npos);
    EXPECT_NE(refusal({0xff}).find("found other data"), std::string::npos);
    const fs::path file = fs::path(testing::TempDir()) / "encoded.png";
    write_picture(file, gradient(3).view());
    std::vector<std::uint8_t> cut = bytes_of(file);
    cut.resize(cut.size() / 2);
    EXPECT_NE(refusal(cut).find("expected a whole PNG image"), std::string::npos);
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

TEST_F(FalseColour, NumbersAreGreyUpToTheHighest) {
    FloatImage samples(4, 2, 1, 0.0f);
    *samples.pixel(1, 0) = 32;
    *samples.pixel(3, 1) = 64;
    frame.planes["samples"] = std::move(samples);
    const ByteImage picture = picture_of_plane(frame, "samples", display);
    EXPECT_EQ(brightness(picture.pixel(0, 0)), 0);
    EXPECT_NEAR(brightness(picture.pixel(1, 0)), 127.5, 0.6);
    EXPECT_EQ(brightness(picture.pixel(2, 0)), 0) << "each pixel its own number";
    EXPECT_EQ(brightness(picture.pixel(3, 1)), 255);
}

TEST_F(FalseColour, LightIsExposedAsTheFrameIs) {
    frame.info.exposure = 4;
    frame.planes["raw"] = FloatImage(4, 2, 3, 0.05f);
    frame.planes["albedo"] = FloatImage(4, 2, 3, 0.05f);
    const int exposed = brightness(picture_of_plane(frame, "raw", display).pixel(0, 0));
    EXPECT_GT(exposed, brightness(picture_of_plane(frame, "albedo", display).pixel(0, 0)) + 30);
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

std::array<int, 3> colour_at(const ByteImage& picture, int x, int y) {
    const std::uint8_t* rgb = picture.pixel(x, y);
    return {rgb[0], rgb[1], rgb[2]};
}

/// Hue, saturation and value turned into sRGB by hand.
TEST_F(FalseColour, ColoursAreThoseOfTheLegend) {
    const ByteImage depth = picture_of_plane(frame, "depth", display);
    EXPECT_EQ(colour_at(depth, 1, 0), (std::array{255, 38, 38}));
    EXPECT_EQ(colour_at(depth, 2, 0), (std::array{19, 13, 89}));
    const ByteImage motion = picture_of_plane(frame, "backward", display);
    EXPECT_EQ(colour_at(motion, 1, 1), (std::array{51, 255, 255}));
    EXPECT_EQ(colour_at(motion, 2, 1), (std::array{255, 51, 51}));
    EXPECT_EQ(colour_at(picture_of_plane(frame, "object_id", display), 1, 0), (std::array{67, 97, 168}));
    FloatImage pairs(4, 2, 12, 0.0f);
    pairs.pixel(1, 0)[0] = std::bit_cast<float>(1u);
    pairs.pixel(1, 0)[1] = 0.5f;
    pairs.pixel(2, 0)[10] = std::bit_cast<float>(1u);  // the last rank, and all of the pixel
    pairs.pixel(2, 0)[11] = 1.0f;
    frame.planes["crypto_object"] = std::move(pairs);
    const ByteImage matte = picture_of_plane(frame, "crypto_object", display);
    EXPECT_EQ(colour_at(matte, 0, 0), (std::array{0, 0, 0}));
    EXPECT_EQ(colour_at(matte, 1, 0), (std::array{34, 48, 84}));
    EXPECT_EQ(colour_at(matte, 2, 0), (std::array{67, 97, 168}));
}

TEST_F(FalseColour, MotionsAreBesideTheLongestOrAFiftiethOfTheWidth) {
    FloatImage motion(100, 2, 2, 0.0f);
    motion.pixel(1, 1)[0] = 0.72f;
    motion.pixel(2, 1)[0] = 50.0f;
    frame.planes["backward"] = std::move(motion);
    const ByteImage picture = picture_of_plane(frame, "backward", display);
    EXPECT_EQ(colour_at(picture, 1, 1), (std::array{31, 153, 153}));  // 0.6, the root of 0.72 / 2
    EXPECT_EQ(brightness(picture.pixel(2, 1)), 255);
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
