#include <tests/unit/scenes/temporary_folder.h>

#include <scenes/sky/sky_image.h>

#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>

namespace equistream::embree_host {
namespace {

using test::expect_contains;
using test::input_error;

class SkyImageFile : public test::TemporaryFolder {
protected:
    /// Writes `samples` (interleaved) as the format that the name's extension says.
    std::filesystem::path save(const std::string& name, OIIO::ImageSpec spec, const std::vector<float>& samples) const {
        const std::filesystem::path file = folder_ / name;
        const auto out = OIIO::ImageOutput::create(file.string());
        EXPECT_TRUE(out && out->open(file.string(), spec)) << OIIO::geterror();
        EXPECT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, samples.data())) << out->geterror();
        EXPECT_TRUE(out->close());
        return file;
    }
    std::string error(const std::filesystem::path& file) const {
        const std::string text = input_error([&] { read_sky_image(file); });
        EXPECT_EQ(text.rfind(file.string(), 0), 0u) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        return text;
    }
};

const OIIO::ImageSpec small(4, 2, 3, OIIO::TypeDesc::FLOAT);

std::vector<float> ramp(std::size_t n) {
    std::vector<float> samples(n);
    for (std::size_t i = 0; i < n; ++i)
        samples[i] = 0.5f * static_cast<float>(i);
    return samples;
}

TEST_F(SkyImageFile, OpenExrAndRadianceAreReadTopRowFirst) {
    for (const char* name : {"sky.exr", "sky.hdr"}) {
        const FloatImage image = read_sky_image(save(name, small, ramp(24)));
        ASSERT_EQ(image.width(), 4);
        ASSERT_EQ(image.height(), 2);
        for (std::size_t i = 0; i < 24; ++i)
            EXPECT_NEAR(image.samples()[i], 0.5f * static_cast<float>(i), 0.01f * 0.5f * static_cast<float>(i) + 0.02f)
                << name << " " << i;
    }
}

TEST_F(SkyImageFile, GreyIsRepeatedAndAlphaLeftAlone) {
    const FloatImage grey =
        read_sky_image(save("grey.exr", OIIO::ImageSpec(2, 1, 1, OIIO::TypeDesc::HALF), {0.25f, 8}));
    EXPECT_EQ(std::vector<float>(grey.samples().begin(), grey.samples().end()),
              (std::vector<float>{0.25f, 0.25f, 0.25f, 8, 8, 8}));
    const FloatImage rgba =
        read_sky_image(save("rgba.exr", OIIO::ImageSpec(1, 1, 4, OIIO::TypeDesc::FLOAT), {1, 2, 3, 0.5f}));
    EXPECT_EQ(rgba.pixel(0, 0)[2], 3);
}

TEST_F(SkyImageFile, PrimariesThatTheFileNamesBecomeRec709) {
    OIIO::ImageSpec acescg(2, 1, 3, OIIO::TypeDesc::FLOAT);
    const float primaries[8] = {0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f};
    acescg.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries);
    const FloatImage image = read_sky_image(save("acescg.exr", acescg, {0.2f, 0.4f, 0.6f, 0, 1, 0}));
    // The matrix that colour-science publishes for ACEScg to linear Rec.709 by Bradford's method.
    const double expected[3] = {1.705051 * 0.2 - 0.621792 * 0.4 - 0.083259 * 0.6,
                                -0.130257 * 0.2 + 1.140805 * 0.4 - 0.010548 * 0.6,
                                -0.024004 * 0.2 - 0.128969 * 0.4 + 1.152972 * 0.6};
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(image.pixel(0, 0)[c], expected[c], 1e-4) << c;
    EXPECT_EQ(image.pixel(1, 0)[0], 0) << "a green beyond Rec.709's";
    EXPECT_NEAR(image.pixel(1, 0)[1], 1.140805, 1e-4);
    const float line[8] = {0.1f, 0.1f, 0.2f, 0.2f, 0.3f, 0.3f, 0.32168f, 0.33767f};
    acescg.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), line);
    expect_contains(error(save("line.exr", acescg, ramp(6))), "expected chromaticities that span a triangle");
}

TEST_F(SkyImageFile, BadPixelsAreNamed) {
    for (const auto& [value, name] :
         {std::pair{-1.0f, "-1.0"}, {std::nanf(""), "nan"}, {std::numeric_limits<float>::infinity(), "inf"}}) {
        std::vector<float> samples = ramp(24);
        samples[3 * (4 * 1 + 2) + 1] = value;
        const std::string text = error(save("bad.exr", small, samples));
        expect_contains(text, "pixel (2, 1): expected radiance that is finite and not negative, found");
        expect_contains(text, name);
    }
}

TEST_F(SkyImageFile, WhatIsNoSkyIsRefused) {
    expect_contains(error(folder_ / "none.exr"), "expected a readable sky image");
    expect_contains(error(write("text.exr", "not an image")), "expected a readable sky image");
    expect_contains(error(save("eight.png", OIIO::ImageSpec(2, 1, 3, OIIO::TypeDesc::UINT8), ramp(6))),
                    "floating-point radiance (.exr, .hdr), found pixels of type uint8");
    expect_contains(error(save("two.exr", OIIO::ImageSpec(2, 1, 2, OIIO::TypeDesc::FLOAT), ramp(4))),
                    "expected channels R, G and B");
    OIIO::ImageSpec odd(2, 1, 3, OIIO::TypeDesc::FLOAT);
    odd.channelnames = {"R\x9b", "G", "B"};  // to a terminal the beginning of a control sequence
    expect_contains(error(save("odd.exr", odd, ramp(6))), "R?");
    OIIO::ImageSpec cube = small;
    cube.attribute("textureformat", "CubeFace Environment");
    expect_contains(error(save("cube.exr", cube, ramp(24))),
                    "expected a lat-long sky image, found the faces of a cube");
    OIIO::ImageSpec crop = small;
    crop.full_width = 8;
    expect_contains(error(save("crop.exr", crop, ramp(24))), "4x2 of its 8x2 pixels");
}

TEST_F(SkyImageFile, ACutFileIsRefused) {
    for (const char* name : {"cut.exr", "cut.hdr"}) {
        const auto file = save(name, OIIO::ImageSpec(64, 32, 3, OIIO::TypeDesc::FLOAT), ramp(64 * 32 * 3));
        std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
        error(file);
    }
}

TEST_F(SkyImageFile, TooLargeOnesAreRefusedByTheirHeaders) {
    write("huge.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 30000 +X 30000\n");
    expect_contains(error(folder_ / "huge.hdr"), "found 30000x30000");
}

}  // namespace
}  // namespace equistream::embree_host
