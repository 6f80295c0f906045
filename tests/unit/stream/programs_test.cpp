/// equistream-encode and equistream-info as a user runs them.
#include "frame_info_matcher.h"
#include "synthetic.h"

#include <equistream/colour.h>
#include <equistream/sequence.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <random>

namespace equistream {
namespace {

namespace fs = std::filesystem;

struct Ran {
    int status;
    std::string output;
    std::string errors;
};

std::string text_of(const fs::path& file) {
    std::ifstream in(file);
    return {std::istreambuf_iterator<char>(in), {}};
}

class Programs : public testing::Test {
protected:
    synthetic::Folder folder;

    Ran run(const std::string& arguments, const std::string& input = "/dev/null") const {
        const std::string command = std::string(EQUISTREAM_BIN) + "/equistream-" + arguments + " >'" +
                                    (folder / "out").string() + "' 2>'" + (folder / "err").string() + "' <'" + input +
                                    "'";
        const int status = std::system(command.c_str());
        return {WEXITSTATUS(status), text_of(folder / "out"), text_of(folder / "err")};
    }
    std::string path(const std::string& name) const { return (folder / name).string(); }

    static FrameInfo info(int width, int height, std::int64_t index, Eye eye) {
        FrameInfo info = synthetic::info(width, height, index, eye);
        info.seed = 1000;  // a render has one
        return info;
    }

    /// Frames whose display-referred picture is synthetic::picture of their index.
    void render(const std::string& name, int width, int height, std::int64_t first, std::int64_t last,
                Eye eye = Eye::centre, std::uint64_t seed = 1000) const {
        fs::create_directories(folder / name);
        const DisplayTransform display;
        for (std::int64_t index = first; index <= last; ++index) {
            Frame frame;
            frame.info = info(width, height, index, eye);
            frame.info.seed = seed;
            const FloatImage linear = display.to_linear(
                widen_8bit(synthetic::picture(width, height, index).view()).view(), frame.info.exposure);
            FloatImage colour(width, height, 4, 1.0f);
            for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                    std::copy_n(linear.pixel(x, y), 3, colour.pixel(x, y));
            frame.planes.emplace("colour", std::move(colour));
            write_exr(folder / name / frame_file_name(index), frame);
        }
    }

    void expect_failure(const Ran& ran, int status, const std::string& part) const {
        EXPECT_EQ(ran.status, status) << ran.errors;
        EXPECT_NE(ran.errors.find(part), std::string::npos) << ran.errors;
        EXPECT_EQ(std::count(ran.errors.begin(), ran.errors.end(), '\n'), 1) << ran.errors;
    }
};

TEST_F(Programs, EncodeMakesBothTracks) {
    render("r/centre", 192, 96, 3, 10);
    render("r/small", 96, 64, 3, 10, Eye::right);
    const std::string words = "encode '" + path("r") + "' --preset veryfast --json --crf 20 --out '";
    const Ran ran = run(words + path("a.mkv") + "' --fill-crf 20");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    const auto report = nlohmann::json::parse(ran.output);
    const auto coarser = nlohmann::json::parse(run(words + path("b.mkv") + "'").output);
    const auto as_coarse = nlohmann::json::parse(run(words + path("c.mkv") + "' --fill-crf 28").output);
    EXPECT_EQ(coarser["tracks"][0]["bytes"], report["tracks"][0]["bytes"]);
    EXPECT_LT(coarser["tracks"][1]["bytes"], report["tracks"][1]["bytes"]);
    EXPECT_EQ(coarser["tracks"][1]["bytes"], as_coarse["tracks"][1]["bytes"]);
    EXPECT_EQ(report["frames"]["count"], 8);
    EXPECT_EQ(report["tracks"].size(), 2u);
    EXPECT_TRUE(report["full_sphere"]);
    EXPECT_GT(report["ms_per_frame"]["encode"], 0.0);
    StreamReader reader(path("a.mkv"));
    const auto pictures = synthetic::read_all(reader);
    ASSERT_EQ(pictures.size(), 16u);
    EXPECT_EQ(reader.truncation(), "");
    for (const DecodedPicture& picture : pictures) {
        ASSERT_TRUE(picture.info);
        const bool main = picture.role == TrackRole::main;
        const int width = main ? 192 : 96, height = main ? 96 : 64;
        FrameInfo expected = info(width, height, picture.info->index, main ? Eye::centre : Eye::right);
        expected.crf = 20.0f;
        EXPECT_EQ(picture.info->coding_loss.has_value(), main);
        expected.coding_loss = picture.info->coding_loss;
        expect_same_info(*picture.info, expected);
        EXPECT_GT(synthetic::psnr_db(picture.rgb, synthetic::picture(width, height, picture.info->index)), 33);
    }
    StreamReader as_usual(path("b.mkv"));
    for (const DecodedPicture& picture : synthetic::read_all(as_usual)) {
        ASSERT_TRUE(picture.info);
        EXPECT_EQ(picture.info->crf, picture.role == TrackRole::main ? 20.0f : 28.0f);
    }
    const auto described = nlohmann::json::parse(run("info '" + path("b.mkv") + "' --json").output);
    EXPECT_EQ(described["tracks"][1]["first_frame"]["crf"], 28);
    EXPECT_NE(run("info '" + path("b.mkv") + "'").output.find("at CRF 20"), std::string::npos);
}

TEST_F(Programs, HiddenLayersAreSentWithTheirDepthThatOfMainOnlyWhenAsked) {
    render("r/centre", 64, 64, 0, 1);
    fs::create_directories(folder / "r/hidden");
    for (std::int64_t index = 0; index < 2; ++index) {
        Frame frame = read_exr(folder / "r/centre" / frame_file_name(index));
        FloatImage depth_m(64, 64, 1, std::nanf(""));
        for (int y = 20; y < 40; ++y)
            std::fill_n(depth_m.pixel(0, y), 8, 2.0f);
        frame.planes.emplace("depth", std::move(depth_m));
        write_exr(folder / "r/hidden" / frame_file_name(index), frame);
    }
    ASSERT_EQ(run("encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'").status, 0);
    StreamReader reader(path("a.mkv"));
    int depths = 0;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        EXPECT_NE(picture.role, TrackRole::depth);
        if (picture.role != TrackRole::hidden_depth)
            continue;
        ++depths;
        EXPECT_TRUE(std::isnan(*picture.depth_m.pixel(4, 4)));
        EXPECT_NEAR(*picture.depth_m.pixel(4, 30), 2.0, 0.05);
    }
    EXPECT_EQ(depths, 2);
}

TEST_F(Programs, WhereAHiddenLayerHoldsNothingItsDepthIsThatOfMain) {
    render("r/centre", 64, 64, 0, 0);
    fs::create_directories(folder / "r/hidden");
    Frame frame = read_exr(folder / "r/centre" / frame_file_name(0));
    FloatImage& depth_m = frame.planes.emplace("depth", FloatImage(64, 64, 1, 1.5f)).first->second;
    write_exr(folder / "r/centre" / frame_file_name(0), frame);
    std::ranges::fill(depth_m.samples(), std::nanf(""));
    for (int y = 20; y < 40; ++y)
        std::fill_n(depth_m.pixel(0, y), 8, 2.0f);
    write_exr(folder / "r/hidden" / frame_file_name(0), frame);
    const auto depth_at = [&](const std::string& file, int x, int y) {
        StreamReader reader(path(file));
        for (const DecodedPicture& picture : synthetic::read_all(reader))
            if (picture.role == TrackRole::hidden_depth)
                return *picture.depth_m.pixel(x, y);
        return 0.0f;
    };
    ASSERT_EQ(run("encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'").status, 0);
    EXPECT_NEAR(depth_at("a.mkv", 4, 30), 2.0, 0.05);
    EXPECT_NEAR(depth_at("a.mkv", 40, 4), 1.5, 0.05);
    const std::string lossless = " --depth lossless --preset ultrafast --out '" + path("b.mkv") + "'";
    ASSERT_EQ(run("encode '" + path("r") + "'" + lossless).status, 0);
    EXPECT_EQ(depth_at("b.mkv", 4, 30), 2.0f);
    EXPECT_TRUE(std::isnan(depth_at("b.mkv", 40, 4)));
}

TEST_F(Programs, EncodeSaysWhichCodecEachTrackGot) {
    render("r", 64, 64, 0, 0);
    Frame frame = read_exr(folder / "r" / frame_file_name(0));
    frame.planes.emplace("depth", FloatImage(64, 64, 1, 1.5f));
    write_exr(folder / "r" / frame_file_name(0), frame);
    const std::string encode =
        "encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "' --depth-crf 20";
    const std::array<std::pair<const char*, const char*>, 5> codes{
        {{"w8", "h264"}, {"w10", "h264"}, {"w12", "h265"}, {"hue", "h265"}, {"lossless", "h265"}}};
    for (const auto& [code, codec] : codes) {
        const Ran ran = run(encode + " --codec h264 --json --depth " + code);
        ASSERT_EQ(ran.status, 0) << ran.errors;
        const nlohmann::json tracks = nlohmann::json::parse(ran.output)["tracks"];
        EXPECT_EQ(tracks[0]["codec"], "h264") << code;
        EXPECT_EQ(tracks[1]["codec"], codec) << code;
        StreamReader reader(path("a.mkv"));
        EXPECT_EQ(reader.tracks()[1].codec, std::string(codec) == "h264" ? "h264" : "hevc") << code;
    }
    EXPECT_NE(run(encode + " --codec h264 --depth w12").output.find(": H.265, "), std::string::npos);
    EXPECT_EQ(run(encode + " --codec h264 --depth w10").output.find("H.265"), std::string::npos);
}

/// Frames whose colour is noise, and what `depth_m` says at each pixel.
class DepthScale : public Programs {
protected:
    static constexpr int side = 128;

    std::string encode(const std::function<float(int, int)>& depth_m, const std::string& more) {
        render("r/centre", side, side, 0, 0);
        Frame frame = read_exr(folder / "r/centre" / frame_file_name(0));
        std::mt19937 random(7);
        for (float& value : frame.planes.at("colour").samples())
            value = float(random() % 1000) / 1000;
        FloatImage plane(side, side, 1);
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x)
                *plane.pixel(x, y) = depth_m(x, y);
        frame.planes.insert_or_assign("depth", std::move(plane));
        write_exr(folder / "r/centre" / frame_file_name(0), frame);
        const Ran ran =
            run("encode '" + path("r") + "' --preset ultrafast --json --out '" + path("a.mkv") + "' " + more);
        EXPECT_EQ(ran.status, 0) << ran.errors;
        return ran.output;
    }
    static nlohmann::json depth_of(const std::string& report) {
        const nlohmann::json read = nlohmann::json::parse(report);
        for (const nlohmann::json& track : read["tracks"])
            if (track["name"] == "depth")
                return track["depth_code"];
        return nullptr;
    }
};

TEST_F(DepthScale, IsChosenByWhatItLeavesWithinTheBudget) {
    // Whole everywhere but along few edges: halving would lose these and gains nothing.
    const auto wall = [](int x, int) { return x < 63 ? 1.0f : 3.0f; };
    EXPECT_EQ(depth_of(encode(wall, "--depth auto"))["scale"], 1);
    // Leaves of two pixels each, and hardly any bits.
    std::mt19937 random(8);
    std::vector<float> leaves(side * side / 4);
    for (float& r : leaves)
        r = 0.6f + float(random() % 1000) / 500;
    const auto foliage = [&](int x, int y) { return leaves[std::size_t(y / 2 * (side / 2) + x / 2)]; };
    const nlohmann::json chosen = depth_of(encode(foliage, "--depth auto --depth-share 0.15"));
    EXPECT_EQ(chosen["scale"], 2) << chosen;
    EXPECT_LE(chosen["trial"]["share_of_colour"], 0.15);
    EXPECT_EQ(depth_of(encode(foliage, "--depth auto --depth-share 0.15 --depth-scale 1"))["scale"], 1);
    EXPECT_NE(run("info '" + path("a.mkv") + "'").output.find("track depth"), std::string::npos);
}

TEST_F(DepthScale, IsOneUnlessAskedForWhereNothingIsTried) {
    const auto wall = [](int, int) { return 2.0f; };
    EXPECT_EQ(depth_of(encode(wall, "--depth w10 --depth-crf 20"))["scale"], 1);
    EXPECT_EQ(depth_of(encode(wall, "--depth lossless"))["scale"], 1);
    EXPECT_EQ(depth_of(encode(wall, "--depth w10 --depth-crf 20 --depth-scale 2"))["scale"], 2);
    EXPECT_NE(run("info '" + path("a.mkv") + "'").output.find("half the columns and rows"), std::string::npos);
    StreamReader reader(path("a.mkv"));
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        EXPECT_EQ(picture.width, side);
    EXPECT_EQ(run("encode '" + path("r") + "' --depth auto --depth-scale 3 --out '" + path("b.mkv") + "'").status, 2);
}

TEST_F(DepthScale, HalvedDepthReachesNearer) {
    const auto near_wall = [](int, int) { return 0.3f; };  // where w10's steps are beyond the budget
    const nlohmann::json whole = depth_of(encode(near_wall, "--depth w10 --depth-crf 20 --depth-scale 1"));
    const nlohmann::json halved = depth_of(encode(near_wall, "--depth w10 --depth-crf 20 --depth-scale 2"));
    EXPECT_EQ(whole["clamped_pixels"], side * side);
    EXPECT_NEAR(whole["bound_in_budgets"], 1, 1e-3);
    EXPECT_EQ(halved["clamped_pixels"], 0);
    EXPECT_NEAR(halved["near_m"], 0.3, 1e-6);
    EXPECT_GT(halved["bound_in_budgets"], 1);
    EXPECT_LE(halved["bound_in_budgets"], 4);
}

TEST_F(Programs, AllDepthTracksTogetherKeepToTheShare) {
    render("r/centre", 128, 128, 0, 0);
    std::mt19937 random(9);
    Frame frame = read_exr(folder / "r/centre" / frame_file_name(0));
    for (float& value : frame.planes.at("colour").samples())
        value = float(random() % 1000) / 1000;
    FloatImage depth_m(128, 128, 1);
    for (float& r : depth_m.samples())
        r = 0.6f + float(random() % 1000) / 500;
    frame.planes.insert_or_assign("depth", std::move(depth_m));
    write_exr(folder / "r/centre" / frame_file_name(0), frame);
    fs::create_directories(folder / "r/hidden");
    write_exr(folder / "r/hidden" / frame_file_name(0), frame);
    const Ran ran = run("encode '" + path("r") + "' --preset ultrafast --depth auto --depth-share 0.5 --json --out '" +
                        path("a.mkv") + "'");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    double colour = 0, depth = 0;
    int depths = 0;
    const nlohmann::json report = nlohmann::json::parse(ran.output);
    for (const nlohmann::json& track : report["tracks"]) {
        if (track["name"] == "main")
            colour = track["bytes"];
        if (track.contains("depth_code")) {
            depth += double(track["bytes"]);
            ++depths;
        }
    }
    EXPECT_EQ(depths, 2);
    EXPECT_LE(depth, 0.5 * colour * 1.01) << "the trial is of this very frame";
    EXPECT_GT(depth, 0.25 * colour);
}

TEST_F(Programs, MirrorsAndGlassGetATrackOnlyWhereThereAreSome) {
    std::mt19937 random(3);
    const auto with_planes = [&](const std::string& name, int side, bool mirror) {
        render("r/" + name, side, side, 0, 1);
        fs::create_directories(folder / name / "centre");
        for (std::int64_t index = 0; index < 2; ++index) {
            Frame frame = read_exr(folder / "r" / name / frame_file_name(index));
            FloatImage specular(side, side, 1, 0), image_m(side, side, 1, 1.5f);
            for (int y = 20; mirror && y < 40; ++y) {
                std::fill_n(specular.pixel(0, y), 16, 1.0f);
                std::fill_n(image_m.pixel(0, y), 16, y < 30 ? 3.0f : std::numeric_limits<float>::infinity());
                // What shows at the surface itself needs no saying.
                std::fill_n(specular.pixel(32, y), 16, 1.0f);
            }
            if (name == "noise")
                for (float& value : frame.planes.at("colour").samples())
                    value = float(random() % 1000) / 1000;
            frame.planes.insert_or_assign("depth", FloatImage(side, side, 1, 1.5f));
            frame.planes.emplace("specular", std::move(specular));
            frame.planes.emplace("virtual_depth", std::move(image_m));
            write_exr(folder / name / "centre" / frame_file_name(index), frame);
        }
        return "encode '" + path(name) + "' --preset ultrafast --out '" + path(name + ".mkv") + "'";
    };
    ASSERT_EQ(run(with_planes("matt", 64, false)).status, 0);
    const std::string mirror = with_planes("mirror", 64, true);
    ASSERT_EQ(run(mirror + " --mirrors none").status, 0);
    for (const char* file : {"matt.mkv", "mirror.mkv"})
        EXPECT_EQ(StreamReader(path(file)).tracks().size(), 1u);
    ASSERT_EQ(run(with_planes("noise", 256, true)).status, 0);
    EXPECT_EQ(StreamReader(path("noise.mkv")).tracks().size(), 2u) << "cheap beside noise";
    // The synthetic colour costs next to nothing, so that any such track is dear beside it.
    const Ran dear = run(mirror + " --json");
    ASSERT_EQ(dear.status, 0);
    EXPECT_GT(nlohmann::json::parse(dear.output)["mirrors_left_out_share"], 0.1);
    EXPECT_EQ(StreamReader(path("mirror.mkv")).tracks().size(), 1u);
    ASSERT_EQ(run(mirror + " --depth-share 1").status, 0);
    EXPECT_EQ(StreamReader(path("mirror.mkv")).tracks().size(), 2u);
    ASSERT_EQ(run(mirror + " --mirrors always").status, 0);
    StreamReader reader(path("mirror.mkv"));
    int images = 0;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        if (picture.role != TrackRole::images)
            continue;
        ++images;
        EXPECT_TRUE(std::isnan(*picture.depth_m.pixel(40, 4)));
        EXPECT_TRUE(std::isnan(*picture.depth_m.pixel(40, 30))) << "moves with its surface";
        EXPECT_NEAR(*picture.depth_m.pixel(6, 24), 3.0, 0.1);
        EXPECT_GT(*picture.depth_m.pixel(6, 35), 100);
    }
    EXPECT_EQ(images, 2);
    // Both tracks are made of the same depths.
    ASSERT_EQ(run(mirror + " --mirrors always --depth lossless").status, 0);
    StreamReader both(path("mirror.mkv"));
    images = 0;
    for (const DecodedPicture& picture : synthetic::read_all(both)) {
        images += picture.role == TrackRole::images;
        if (picture.role == TrackRole::depth || picture.role == TrackRole::images) {
            EXPECT_NEAR(*picture.depth_m.pixel(6, 24), picture.role == TrackRole::images ? 3.0 : 1.5, 0.1);
            EXPECT_EQ(std::isnan(*picture.depth_m.pixel(40, 4)), picture.role == TrackRole::images);
        }
    }
    EXPECT_EQ(images, 2);
    ASSERT_EQ(run(mirror + " --mirrors always").status, 0);
    const auto fine = fs::file_size(path("mirror.mkv"));
    ASSERT_EQ(run(mirror + " --mirrors always --depth-crf 51").status, 0);
    EXPECT_LT(fs::file_size(path("mirror.mkv")), fine);
    EXPECT_NE(run("info '" + path("mirror.mkv") + "'").output.find("track images"), std::string::npos);
}

TEST_F(Programs, EncodeChoosesFoldersAndFrames) {
    render("r/left", 64, 64, 0, 3, Eye::left);
    render("r/right", 64, 64, 0, 5, Eye::right);
    render("r/small", 64, 64, 0, 1, Eye::right);
    const std::string r = "encode '" + path("r");
    const auto tracks = [&](const std::string& more) {
        const Ran ran = run(r + more + " --json --preset ultrafast --out '" + path("a.mkv") + "'");
        EXPECT_EQ(ran.status, 0) << ran.errors;
        return nlohmann::json::parse(ran.output, nullptr, false);
    };
    EXPECT_EQ(tracks("' --fill none")["tracks"][0]["folder"], path("r/left"));
    EXPECT_EQ(tracks("' --fill none --eye right")["frames"]["last"], 5);
    EXPECT_EQ(tracks("/right' --frames 2-4")["frames"]["count"], 3);
    EXPECT_EQ(tracks("/left'")["tracks"].size(), 1u);
    EXPECT_EQ(tracks("/left' --fill small --frames 0-1")["tracks"].size(), 2u);
    const std::string out = " --out '" + path("b.mkv") + "'";
    expect_failure(run(r + "'" + out), 2, "small: expected frames 0-3, found no frame.0002.exr");
    expect_failure(run(r + "' --eye centre" + out), 2, "centre: expected frame.NNNN.exr files, found none");
    expect_failure(run(r + "' --fill none --frames 2-9" + out), 2, "found no frame.0004.exr");
    expect_failure(run(r + "' --frames 9-2" + out), 2, "9-2");
    expect_failure(run(r + "' --fill both" + out), 2, "small");
    EXPECT_FALSE(fs::exists(folder / "b.mkv"));
}

TEST_F(Programs, EncodeSaysWhatIsWrong) {
    render("r/centre", 64, 64, 0, 1);
    render("odd", 65, 64, 0, 0);
    fs::create_directories(folder / "empty");
    const std::string r = "encode '" + path("r") + "' --out '" + path("a.mkv") + "'";
    expect_failure(run("encode '" + path("none") + "' --out a.mkv"), 2, "found nothing");
    expect_failure(run("encode '" + path("empty") + "' --out a.mkv"), 2, "found an empty folder");
    expect_failure(run("encode '" + path("odd") + "' --out '" + path("o.mkv") + "'"), 2, "found 65x64");
    expect_failure(run("encode '" + path("r") + "' --out '" + path("a.wmv") + "'"), 2, "ending in one of .mp4");
    expect_failure(run(r + " --crf 77"), 2, "--crf: expected 0 to 51, found 77");
    expect_failure(run(r + " --fill-crf 77"), 2, "--fill-crf: expected 0 to 51, found 77");
    expect_failure(run(r + " --gop 0"), 2, "--gop: expected 1 to 10000, found 0");
    expect_failure(run(r + " --preset swift"), 2, "--preset: expected one of ultrafast");
    expect_failure(run(r + " --depth-share 10"), 2, "at most 1, 0.1 being 10 %, found 10");
    expect_failure(run(r + " --depth-share 0"), 2, "--depth-share: expected a share");
    expect_failure(run(r + " --codec av1"), 2, "codec");
    expect_failure(run("encode '" + path("r") + "' --out '" + path("no/such/a.mkv") + "'"), 2,
                   "No such file or directory");
}

TEST_F(Programs, AFrameThatIsDamagedKeepsWhatCameBefore) {
    render("r", 64, 64, 0, 9);
    fs::resize_file(folder / "r" / "frame.0006.exr", 700);
    const Ran ran = run("encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'");
    expect_failure(ran, 1, "frame.0006.exr");
    EXPECT_NE(ran.errors.find("kept in " + path("a.mkv.part")), std::string::npos) << ran.errors;
    EXPECT_FALSE(fs::exists(folder / "a.mkv"));
    StreamReader reader(path("a.mkv.part"));
    EXPECT_EQ(synthetic::read_all(reader).size(), 6u);
    EXPECT_NE(reader.truncation().find("cut after frame 5 (6 of 10 pictures play)"), std::string::npos);
}

TEST_F(Programs, AFrameOfAnotherSizeIsNamed) {
    render("r", 64, 64, 0, 5);
    render("r", 96, 64, 3, 3);
    const Ran ran = run("encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'");
    expect_failure(
        ran, 1, path("r/frame.0003.exr") + ": expected 64x64 pixels as in the frames before it, found 96x64; what was");
    EXPECT_FALSE(fs::exists(folder / "a.mkv"));
}

TEST_F(Programs, AFrameOfAnotherRenderIsNamed) {
    render("r", 64, 64, 0, 5);
    render("r", 64, 64, 3, 3, Eye::centre, 1001);
    const std::string encode = "encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'";
    const std::string frame = path("r/frame.0003.exr");
    expect_failure(run(encode), 1, frame + ": expected seed 1000 as in the frames before it, found 1001; what was");
    Manifest manifest;
    manifest.shared = info(64, 64, 0, Eye::centre);
    write_manifest(folder / "r", manifest);
    expect_failure(run(encode + " --frames 3"), 2,
                   frame + ": expected seed 1000 as in " + path("r/manifest.json") + ", found 1001");
    EXPECT_FALSE(fs::exists(folder / "a.mkv"));
    EXPECT_EQ(run(encode + " --frames 0-2").status, 0);
}

TEST_F(Programs, AFullDiskIsOneLine) {
    render("r", 192, 96, 0, 9);
    fs::create_symlink("/dev/full", folder / "full.mkv");
    expect_failure(run("encode '" + path("r") + "' --out '" + path("full.mkv") + "'"), 1, "No space left on device");
    fs::create_directories(folder / "disk");
    if (mount("none", (folder / "disk").c_str(), "tmpfs", 0, "size=32k") != 0)
        GTEST_SKIP() << "mounting a small file system needs root; /dev/full was tried";
    expect_failure(run("encode '" + path("r") + "' --crf 0 --out '" + path("disk/a.mkv") + "'"), 1,
                   "No space left on device; what was coded so far is kept in");
    EXPECT_FALSE(fs::exists(folder / "disk" / "a.mkv"));
    umount((folder / "disk").c_str());
}

TEST_F(Programs, InfoExplainsAStream) {
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h265, true));
    const Ran text = run("info '" + path("a.mkv") + "'");
    ASSERT_EQ(text.status, 0) << text.errors;
    for (const char* part :
         {"track main: hevc, 192x96", "track small:", "12 pictures", "scene      waves, exposure 1.5",
          "geometry   fingerprint 0123456789abcdef", "tv/bt709/iec61966-2-1/bt709", "frames     5 to 16",
          "x 0.500 to 1.600", "eye        right", "stay within 0.1315 m", "whole: nothing is missing"})
        EXPECT_NE(text.output.find(part), std::string::npos) << part << "\n" << text.output;
    const auto json = nlohmann::json::parse(run("info --json --frames '" + path("a.mkv") + "'").output);
    EXPECT_EQ(json["tracks"][1]["frames"].size(), 12u);
    EXPECT_EQ(json["tracks"][0]["first_frame"]["seed"], 1005);
    EXPECT_TRUE(json["whole"]);
    fs::resize_file(folder / "a.mkv", fs::file_size(folder / "a.mkv") * 3 / 4);
    const Ran cut = run("info '" + path("a.mkv") + "'");
    EXPECT_EQ(cut.status, 0);
    EXPECT_NE(cut.output.find("not whole: "), std::string::npos) << cut.output;
}

TEST_F(Programs, InfoSaysHowManySamplesWereNotFinite) {
    Frame frame;
    frame.info = info(64, 32, 0, Eye::centre);
    frame.planes.emplace("colour", FloatImage(64, 32, 4, 0.5f));
    write_exr(folder / "spoiled.exr", frame, {.left_out_samples = 7});
    const Ran spoiled = run("info '" + path("spoiled.exr") + "'");
    EXPECT_NE(spoiled.output.find("left out   7 samples"), std::string::npos) << spoiled.output;
    EXPECT_EQ(nlohmann::json::parse(run("info --json '" + path("spoiled.exr") + "'").output)["left_out_samples"], 7);
    write_exr(folder / "good.exr", frame);
    EXPECT_EQ(run("info '" + path("good.exr") + "'").output.find("left out"), std::string::npos);
}

TEST_F(Programs, InfoExplainsFramesAndFolders) {
    render("r/centre", 64, 32, 0, 2);
    render("r/centre", 64, 32, 5, 5);
    const Ran exr = run("info '" + path("r/centre/frame.0001.exr") + "'");
    ASSERT_EQ(exr.status, 0) << exr.errors;
    for (const char* part : {"part rgba: 64x32", "colour [radiance]", "frame 1 at", "scene      waves", "equirect"})
        EXPECT_NE(exr.output.find(part), std::string::npos) << part << "\n" << exr.output;
    const Ran sequence = run("info '" + path("r") + "'");
    ASSERT_EQ(sequence.status, 0) << sequence.errors;
    for (const char* part : {"sequence of 4 frames", "present    0-2, 5", "missing    3-4"})
        EXPECT_NE(sequence.output.find(part), std::string::npos) << part << "\n" << sequence.output;
    const auto json = nlohmann::json::parse(run("info --json '" + path("r") + "'").output);
    EXPECT_EQ(json["sequences"][0]["count"], 4);
}

TEST_F(Programs, EncodeReportsBesideTheStreamItWritesToStandardOutput) {
    render("r", 64, 64, 0, 2);
    const std::string encode = "encode '" + path("r") + "' --preset ultrafast --out ";
    ASSERT_EQ(run(encode + "'" + path("a.ts") + "'").status, 0);
    for (const char* target : {"pipe:1", "pipe:", "pipe:1 --json"}) {
        const Ran ran = run(encode + target);
        ASSERT_EQ(ran.status, 0) << ran.errors;
        EXPECT_EQ(ran.output, text_of(folder / "a.ts")) << "the stream and nothing else: " << target;
        const char* report =
            std::string(target).ends_with("--json") ? "\"frames_per_second\": 30" : "frames 0-2, H.264";
        EXPECT_NE(ran.errors.find(report), std::string::npos) << ran.errors;
        EXPECT_EQ(ran.errors.find("360 degree"), std::string::npos) << "MPEG-TS has no place for the tag";
    }
    EXPECT_NE(run(encode + "'" + path("a.mkv") + "'").output.find("tagged as 360 degree video"), std::string::npos);
    EXPECT_EQ(run(encode + "'" + path("a.ts") + "'").output.find("tagged as"), std::string::npos);
}

TEST_F(Programs, InfoReadsAPipe) {
    synthetic::write(folder / "a.ts", synthetic::small_stream(Codec::h264, false));
    const Ran ran = run("info pipe:0", path("a.ts"));
    EXPECT_EQ(ran.status, 0) << ran.errors;
    EXPECT_NE(ran.output.find("track main: h264, 192x96"), std::string::npos) << ran.output;
}

TEST_F(Programs, InfoKeepsControlCharactersOffTheTerminal) {
    render("r", 64, 32, 0, 0);
    Frame frame = read_exr(folder / "r" / frame_file_name(0));
    frame.info.scene = "waves\x1b[31m\nforged line";
    frame.info.host = "host\r\x07";
    frame.info.camera = PerspectiveCamera{64, 32, 1};
    write_exr(folder / "r" / frame_file_name(0), frame);
    Manifest manifest;
    manifest.shared = frame.info;
    manifest.planes = {"colour"};
    manifest.command = "render\x1b]0;title\x07";
    write_manifest(folder / "r", manifest);
    for (const std::string& source : {path("r"), path("r/frame.0000.exr")}) {
        const Ran ran = run("info '" + source + "'");
        ASSERT_EQ(ran.status, 0) << ran.errors;
        EXPECT_NE(ran.output.find("waves?[31m?forged line"), std::string::npos) << ran.output;
        EXPECT_TRUE(std::ranges::none_of(ran.output, [](char c) { return c != '\n' && c >= 0 && c < 0x20; }));
        EXPECT_EQ(ran.output.find("axes locked"), std::string::npos) << "a perspective camera turns with the head";
    }
}

TEST_F(Programs, InfoSaysWhereNoPictureCouldBeRead) {
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h264, false));
    std::string bytes = text_of(folder / "a.mkv");
    const std::string uuid = "\x69\xc4\x80\x36\x51\x33\x47\x84\x80\x93\xec\x66\xa7\x47\x51\x19";
    bytes.resize(bytes.find(uuid) + uuid.size());
    std::ofstream(folder / "a.mkv", std::ios::binary) << bytes;
    const Ran ran = run("info '" + path("a.mkv") + "'");
    EXPECT_EQ(ran.status, 0) << ran.errors;
    EXPECT_NE(ran.output.find("  no picture could be read\n"), std::string::npos) << ran.output;
    EXPECT_EQ(ran.output.find("ordinary video"), std::string::npos) << ran.output;
}

TEST_F(Programs, InfoIsPoliteAboutTheRest) {
    fs::create_directories(folder / "empty");
    std::ofstream(folder / "notes.txt") << "nothing to see\n";
    std::ofstream(folder / "bad.exr") << "v/1\x01 and then nonsense";
    expect_failure(run("info '" + path("absent") + "'"), 2, "no such file or folder");
    expect_failure(run("info '" + path("empty") + "'"), 2, "found none");
    expect_failure(run("info '" + path("notes.txt") + "'"), 2, "expected a video");
    expect_failure(run("info '" + path("bad.exr") + "'"), 2, "expected an EXR file");
}

}  // namespace
}  // namespace equistream
