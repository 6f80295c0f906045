/// What equistream-export writes, read back by OpenImageIO and by OpenEXR.
#include <tests/unit/programs/programs_fixture.h>

#include <equistream/text.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineInputFile.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>

namespace equistream::test {
namespace {

constexpr int width = 12, height = 6;
constexpr float nothing = std::numeric_limits<float>::quiet_NaN(), sky = std::numeric_limits<float>::infinity();

float value(int x, int y, int channel) {
    return float(x) / 8 + float(y) * 2 + float(channel) / 4;  // halves hold it
}

class Export : public Programs {
protected:
    /// Sky in the first row; something hidden in every third column, the sky in the last row.
    void render_both(Eye eye = Eye::centre, const std::string& name = "centre") const {
        std::filesystem::create_directories(folder / "r" / name);
        Frame frame;
        frame.info = info(width, height, 3, eye);
        frame.planes.emplace("colour", colours(0, 0.5f));
        FloatImage depth_m(width, height, 1);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                *depth_m.pixel(x, y) = y == 0 ? sky : 1.1f + float(x);
        frame.planes.emplace("depth", std::move(depth_m));
        write_exr(folder / "r" / name / frame_file_name(3), frame);
    }
    void render_hidden() const {
        std::filesystem::create_directories(folder / "r/hidden");
        Frame frame;
        frame.info = info(width, height, 3, Eye::centre);
        frame.planes.emplace("colour", colours(100, 1));
        FloatImage depth_m(width, height, 1, nothing);
        for (int y = 1; y < height; ++y)
            for (int x = 0; x < width; x += 3)
                *depth_m.pixel(x, y) = y == height - 1 ? sky : 20.3f + float(x);
        *depth_m.pixel(6, 2) = 0.5f;  // before the front
        frame.planes.emplace("depth", std::move(depth_m));
        write_exr(folder / "r/hidden" / frame_file_name(3), frame);
    }
    static FloatImage colours(float base, float alpha) {
        FloatImage colour(width, height, 4, alpha);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 3; ++c)
                    colour.pixel(x, y)[c] = base + value(x, y, c);
        return colour;
    }
    static bool hides(int x, int y) { return y > 0 && x % 3 == 0 && !(x == 6 && y == 2); }

    std::string made(const std::string& options) const {
        const Ran ran = run("export '" + path("r") + "' --out '" + path("made") + "' " + options);
        EXPECT_EQ(ran.status, 0) << ran.errors;
        EXPECT_EQ(ran.errors, "");
        return ran.output;
    }
    std::string file() const { return path("made/" + frame_file_name(3)); }
};

TEST_F(Export, DeepSamplesAreTheFrontAndWhatItHides) {
    render_both();
    render_hidden();
    const auto report = nlohmann::json::parse(made("--json"));
    EXPECT_EQ(report["samples"]["front"], width * height);
    EXPECT_EQ(report["samples"]["left_out"], 1);
    const auto input = OIIO::ImageInput::open(file());
    ASSERT_TRUE(input) << OIIO::geterror();
    const OIIO::ImageSpec spec = input->spec();
    ASSERT_TRUE(spec.deep);
    EXPECT_EQ(spec.get_string_attribute("equistream:camera"), "equirect");
    EXPECT_EQ(spec.get_string_attribute("wrapmodes"), "periodic,clamp");
    OIIO::DeepData deep;
    ASSERT_TRUE(input->read_native_deep_image(0, 0, deep));
    std::int64_t hidden = 0;
    const auto channel = [&](const char* name) { return spec.channelindex(name); };
    for (const char* name : {"R", "G", "B", "A"})
        EXPECT_EQ(spec.channelformat(channel(name)), OIIO::TypeHalf);
    for (const char* name : {"Z", "ZBack"})
        EXPECT_EQ(spec.channelformat(channel(name)), OIIO::TypeFloat);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const std::int64_t pixel = std::int64_t{y} * width + x;
            ASSERT_EQ(deep.samples(pixel), hides(x, y) ? 2 : 1) << x << " " << y;
            hidden += deep.samples(pixel) - 1;
            for (int s = 0; s < deep.samples(pixel); ++s) {
                const float z = s == 0            ? (y == 0 ? 1e10f : 1.1f + float(x))
                                : y == height - 1 ? 1e10f
                                                  : 20.3f + float(x);
                EXPECT_EQ(deep.deep_value(pixel, channel("Z"), s), z);
                EXPECT_EQ(deep.deep_value(pixel, channel("ZBack"), s), z);
                EXPECT_EQ(deep.deep_value(pixel, channel("A"), s), 1);
                int c = 0;
                for (const char* name : {"R", "G", "B"})
                    EXPECT_EQ(deep.deep_value(pixel, channel(name), s), (s == 0 ? 0 : 100) + value(x, y, c++));
                if (s > 0) {
                    EXPECT_GT(z, deep.deep_value(pixel, channel("Z"), s - 1)) << "nearest first";
                }
            }
        }
    EXPECT_EQ(report["samples"]["hidden"], hidden);
    // Flattened by OpenImageIO it is the front picture.
    const OIIO::ImageBuf flat = OIIO::ImageBufAlgo::flatten(OIIO::ImageBuf(file()));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                EXPECT_EQ(flat.getchannel(x, y, 0, c), value(x, y, c));
}

TEST_F(Export, OpenExrReadsTheDeepFile) {
    render_both();
    render_hidden();
    made("");
    Imf::DeepScanLineInputFile input(file().c_str());
    EXPECT_EQ(input.header().compression(), Imf::ZIPS_COMPRESSION);
    std::vector<unsigned> counts(width * height);
    std::vector<float*> pointers(counts.size());
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, reinterpret_cast<char*>(counts.data()), sizeof(unsigned), sizeof(unsigned) * width));
    buffer.insert("Z", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(pointers.data()), sizeof(float*),
                                      sizeof(float*) * width, sizeof(float)));
    input.setFrameBuffer(buffer);
    input.readPixelSampleCounts(0, height - 1);
    std::vector<std::vector<float>> depths(counts.size());
    for (std::size_t i = 0; i < counts.size(); ++i) {
        depths[i].resize(counts[i]);
        pointers[i] = depths[i].data();
    }
    input.readPixels(0, height - 1);
    EXPECT_EQ(depths[std::size_t(4 * width + 3)], (std::vector{4.1f, 23.3f}));
    EXPECT_EQ(depths[std::size_t(2 * width + 6)], (std::vector{7.1f}));
}

TEST_F(Export, PartsAreCalledAsCompositingProgramsCallThem) {
    render_both();
    render_hidden();
    made("--layout parts");
    const auto input = OIIO::ImageInput::open(file());
    ASSERT_TRUE(input);
    std::vector<std::string> names;
    for (int part = 0; input->seek_subimage(part, 0); ++part)
        names.push_back(input->spec().get_string_attribute("oiio:subimagename"));
    EXPECT_EQ(names, (std::vector<std::string>{"rgba", "depth", "hidden"}));
    ASSERT_TRUE(input->seek_subimage(2, 0));
    const OIIO::ImageSpec spec = input->spec();
    std::vector<float> pixels(std::size_t(width * height * spec.nchannels));
    ASSERT_TRUE(input->read_image(2, 0, 0, spec.nchannels, OIIO::TypeFloat, pixels.data()));
    const auto at = [&](int x, int y, const char* channel) {
        return pixels[std::size_t((y * width + x) * spec.nchannels + spec.channelindex(channel))];
    };
    EXPECT_EQ(at(3, 2, "hidden.R"), 100 + value(3, 2, 0));
    EXPECT_EQ(at(3, 2, "hidden.A"), 1);
    EXPECT_EQ(at(3, 2, "hidden.Z"), 23.3f);
    EXPECT_EQ(at(4, 2, "hidden.R"), 0);
    EXPECT_EQ(at(4, 2, "hidden.A"), 0);
    EXPECT_TRUE(std::isinf(at(4, 2, "hidden.Z")));
}

TEST_F(Export, BothEyesAreViews) {
    render_both(Eye::left, "left");
    render_both(Eye::right, "right");
    made("--layout parts");
    const auto input = OIIO::ImageInput::open(file());
    ASSERT_TRUE(input);
    std::string found;
    for (int part = 0; input->seek_subimage(part, 0); ++part)
        found += std::string(input->spec().get_string_attribute("oiio:subimagename")) + ":" +
                 std::string(input->spec().get_string_attribute("view")) + " ";
    EXPECT_EQ(found, "rgba.left:left depth.left:left rgba.right:right depth.right:right ");
    EXPECT_EQ(nlohmann::json::parse(made("--layout deep --eye right --overwrite --json"))["hidden"], false);
}

TEST_F(Export, WhatCannotBeExportedIsRefusedInALine) {
    const std::string out = " --out '" + path("made") + "'";
    expect_failure(run("export '" + path("nowhere") + "'" + out), 2, "expected a folder of frames, found nothing");
    std::filesystem::create_directories(folder / "r/centre");
    expect_failure(run("export '" + path("r") + "'" + out), 2, "expected frame.NNNN.exr files");
    render("r/centre", width, height, 3, 3);
    expect_failure(run("export '" + path("r") + "'" + out), 2, "expected plane depth, for the samples' places");
    render_both();
    made("");
    expect_failure(run("export '" + path("r") + "'" + out), 2,
                   "expected no file of this name, or --overwrite, found one");
    expect_failure(run("export '" + path("r") + "' --overwrite --frames 7" + out), 2, "found none in this range");
    EXPECT_NE(run("info '" + file() + "'").output.find("part"), std::string::npos);
    render_hidden();
    Frame other = read_exr(folder / "r/hidden" / frame_file_name(3));
    other.info.scene = "another";
    write_exr(folder / "r/hidden" / frame_file_name(3), other);
    expect_failure(run("export '" + path("r") + "' --overwrite" + out), 2,
                   "hidden, frame 3: expected the scene of " + path("r/centre"));
}

TEST_F(Export, TheEyeThatADeepFileLeavesOutIsNamed) {
    render_both(Eye::left, "left");
    EXPECT_EQ(made("--overwrite").find("not exported"), std::string::npos);
    render_both(Eye::right, "right");
    EXPECT_NE(made("--overwrite").find("  right not exported: a deep file holds one eye"), std::string::npos);
    EXPECT_EQ(made("--overwrite --eye right").find("not exported"), std::string::npos);
    EXPECT_EQ(made("--overwrite --layout parts").find("not exported"), std::string::npos);
    EXPECT_EQ(nlohmann::json::parse(made("--overwrite --json"))["eyes_left_out"], nlohmann::json::array({"right"}));
}

/// Other commands would take the files for the render's own frames.
TEST_F(Export, NothingIsWrittenIntoTheRender) {
    render_both();
    const auto refused = [&](const std::string& source, const std::string& out) {
        expect_failure(run("export '" + path(source) + "' --layout parts --out '" + path(out) + "'"), 2,
                       "expected an output outside the input, found");
    };
    refused("r", "r");
    refused("r", "r/comp");
    refused("r/centre", "r");
    refused("r/centre/", "r");
    refused("r/centre", "r/comp");
    EXPECT_FALSE(std::filesystem::exists(folder / "r" / frame_file_name(3)));
    EXPECT_FALSE(std::filesystem::exists(folder / "r/comp"));
    EXPECT_EQ(run("export '" + path("r") + "' --out '" + path(".") + "'").status, 0);
}

}  // namespace
}  // namespace equistream::test
