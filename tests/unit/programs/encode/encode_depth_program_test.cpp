/// Tracks of depth, hidden layers and mirrors that equistream-encode adds: which, in which code and how large.
#include <tests/unit/programs/programs_fixture.h>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <random>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

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
    const std::string encode = "encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "'";
    const std::array<std::pair<const char*, const char*>, 5> codes{
        {{"w8", "h264"}, {"w10", "h264"}, {"w12", "h265"}, {"hue", "h265"}, {"lossless", "h265"}}};
    for (const auto& [code, codec] : codes) {
        const std::string crf = std::string(code) == "lossless" ? "" : " --depth-crf 20";
        const Ran ran = run(encode + crf + " --codec h264 --json --depth " + code);
        ASSERT_EQ(ran.status, 0) << ran.errors;
        const nlohmann::json tracks = nlohmann::json::parse(ran.output)["tracks"];
        EXPECT_EQ(tracks[0]["codec"], "h264") << code;
        EXPECT_EQ(tracks[1]["codec"], codec) << code;
        StreamReader reader(path("a.mkv"));
        EXPECT_EQ(reader.tracks()[1].codec, std::string(codec) == "h264" ? "h264" : "hevc") << code;
    }
    const std::string coarse = encode + " --depth-crf 20";
    EXPECT_NE(run(coarse + " --codec h264 --depth w12").output.find(": H.265, "), std::string::npos);
    EXPECT_EQ(run(coarse + " --codec h264 --depth w10").output.find("H.265"), std::string::npos);
    expect_failure(run(coarse + " --depth lossless"), 2, "--depth-crf: expected lossy depth");
    expect_failure(run(coarse + " --depth w10 --depth-share 0.2"), 2,
                   "--depth-share: expected no --depth-crf, which replaces it");
    EXPECT_NE(run(coarse + " --depth w10 --mirrors always").output.find("no track of mirrors and glass: "),
              std::string::npos);
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

TEST_F(DepthScale, TheReportJudgesTheTrial) {
    const auto wall = [](int x, int) { return x < 63 ? 1.0f : 3.0f; };
    const nlohmann::json fine = depth_of(encode(wall, "--depth auto"))["trial"];
    EXPECT_EQ(fine["judgement"], "fine") << fine;
    // Every pixel at a depth of its own, and next to no bits for them.
    std::mt19937 random(8);
    const auto chaos = [&](int, int) { return 0.6f + float(random() % 1000) / 500; };
    const nlohmann::json starved = depth_of(encode(chaos, "--depth auto --depth-share 0.01"));
    EXPECT_EQ(starved["crf"], 42) << "coarser depth costs far more than its bits";
    const nlohmann::json poor = starved["trial"];
    EXPECT_EQ(poor["judgement"], "poor") << poor;
    EXPECT_LT(poor["pixels_within_budget"], 0.4);
    const Ran text = run("encode '" + path("r") + "' --preset ultrafast --depth auto --depth-share 0.01 --out '" +
                         path("a.mkv") + "'");
    EXPECT_NE(text.output.find("that is poor: may be decibels below exact depth; use a larger --depth-share"),
              std::string::npos)
        << text.output;
    EXPECT_NE(text.output.find("depth takes more than 1.0 % of the colour's bits"), std::string::npos) << text.output;
}

TEST_F(DepthScale, AShareThatLeavesFewPixelsWithinTheBudgetGrows) {
    const auto wall = [](int x, int) { return x < 63 ? 1.0f : 3.0f; };
    EXPECT_EQ(depth_of(encode(wall, "--depth auto"))["trial"]["share_allowed"], 0.1);
    // Leaves of four by four pixels: a tenth of the colour's bits is too little, and twice as many help.
    std::mt19937 random(8);
    std::vector<float> leaves(side * side / 16);
    for (float& r : leaves)
        r = 0.6f + float(random() % 1000) / 500;
    const auto foliage = [&](int x, int y) { return leaves[std::size_t(y / 4 * (side / 4) + x / 4)]; };
    const nlohmann::json tenth = depth_of(encode(foliage, "--depth auto --depth-share 0.1"))["trial"];
    ASSERT_LT(tenth["pixels_within_budget"], 0.4) << tenth;
    const nlohmann::json grown = depth_of(encode(foliage, "--depth auto"))["trial"];
    EXPECT_GT(grown["share_allowed"], 0.1) << grown;
    EXPECT_GE(double(grown["pixels_within_budget"]), double(tenth["pixels_within_budget"]) + 0.05) << grown << tenth;
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

/// In pece420 three of four pixels may drag the fourth along three quarters of a wave of 256 steps; 4:4:4 rounds alone.
TEST_F(DepthScale, TheBoundCountsDepthsThatShareASample) {
    const auto wall = [](int x, int) { return x < 63 ? 1.0f : 3.0f; };
    const auto bound = [&](const std::string& code) {
        return double(depth_of(encode(wall, "--depth-crf 20 --depth " + code))["bound_in_budgets"]);
    };
    EXPECT_NEAR(bound("pece420") / bound("pece444"), 192.75, 0.05);
    const Ran text = run("encode '" + path("r") + "' --depth pece420 --depth-crf 20 --out '" + path("a.mkv") + "'");
    EXPECT_NE(text.output.find(", at worst: where depths that share a sample differ"), std::string::npos)
        << text.output;
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
        if (picture.role != TrackRole::reflections)
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
        images += picture.role == TrackRole::reflections;
        if (picture.role == TrackRole::depth || picture.role == TrackRole::reflections) {
            EXPECT_NEAR(*picture.depth_m.pixel(6, 24), picture.role == TrackRole::reflections ? 3.0 : 1.5, 0.1);
            EXPECT_EQ(std::isnan(*picture.depth_m.pixel(40, 4)), picture.role == TrackRole::reflections);
        }
    }
    EXPECT_EQ(images, 2);
    ASSERT_EQ(run(mirror + " --mirrors always").status, 0);
    const auto fine = fs::file_size(path("mirror.mkv"));
    ASSERT_EQ(run(mirror + " --mirrors always --depth-crf 51").status, 0);
    EXPECT_LT(fs::file_size(path("mirror.mkv")), fine);
    EXPECT_NE(run("info '" + path("mirror.mkv") + "'").output.find("track images"), std::string::npos);
}

}  // namespace
}  // namespace equistream::test
