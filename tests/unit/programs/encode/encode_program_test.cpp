/// What equistream-encode makes of folders of frames, and what it says of those it cannot take.
#include <tests/unit/plugin/stream/synthetic.h>
#include <tests/unit/programs/programs_fixture.h>

#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <map>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

/// What coding takes is said, and no video fails for want of a place to measure it.
TEST_F(Programs, EncodeSaysWhatCodingTakesOrWhyItDoesNot) {
    render("r/centre", 96, 64, 0, 9);
    const std::string words = "encode '" + path("r") + "' --preset veryfast --crf 30 --json --out '";
    const Ran ran = run(words + path("a.mkv") + "'");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    const auto loss = nlohmann::json::parse(ran.output)["visible_loss"];
    EXPECT_EQ(loss["frames"], 8);
    ASSERT_EQ(loss["by_texture"].size(), VisibleLoss::textures.size());
    const auto described = nlohmann::json::parse(run("info '" + path("a.mkv") + "' --json").output);
    EXPECT_EQ(described["tracks"][0]["first_frame"]["visible_loss"], loss["by_texture"]);
    EXPECT_NE(run("info '" + path("a.mkv") + "'").output.find("of flat pixels are visibly off"), std::string::npos);

    setenv("TMPDIR", path("nowhere").c_str(), 1);
    const Ran without = run(words + path("b.mkv") + "'");
    const Ran told = run("encode '" + path("r") + "' --preset veryfast --out '" + path("c.mkv") + "'");
    unsetenv("TMPDIR");
    ASSERT_EQ(without.status, 0) << without.errors;
    EXPECT_TRUE(nlohmann::json::parse(without.output)["visible_loss"].is_null());
    EXPECT_NE(told.output.find("visible error not measured"), std::string::npos) << told.output;
}

/// A target that cannot be written is found before anything is coded.
TEST_F(Programs, EncodeLooksAtItsTargetFirst) {
    render("r/centre", 96, 64, 0, 1);
    setenv("TMPDIR", path("nowhere").c_str(), 1);
    expect_failure(run("encode '" + path("r") + "' --out '" + path("no/such/folder/a.mkv") + "'"), 2,
                   "expected a place that can be written");
    unsetenv("TMPDIR");
}

/// What has no frame data is not ours, or not certain to be.
TEST_F(Programs, EncodeReplacesItsOwnStreamsAlone) {
    render("r/centre", 96, 64, 0, 1);
    const auto encode = [&](const std::string& name) {
        return run("encode '" + path("r") + "' --preset ultrafast --out '" + path(name) + "'");
    };
    for (const char* name : {"a.mp4", "a.mkv", "a.ts", "a.h264"})
        for (int i = 0; i < 2; ++i)
            EXPECT_EQ(encode(name).status, 0) << name;
    std::ofstream(folder / "empty.mkv").flush();
    EXPECT_EQ(encode("empty.mkv").status, 0);
    std::ofstream(folder / "text.mp4") << "another's";
    synthetic::Made made = synthetic::small_stream(Codec::h264, false);
    made.settings.tagged = false;
    made.settings.tracks.resize(1);
    synthetic::write(folder / "video.h264", made);
    for (const char* name : {"text.mp4", "video.h264"}) {
        const std::string before = text_of(folder / name);
        expect_failure(encode(name), 2,
                       "--out " + path(name) +
                           ": expected a new name, or an earlier stream of equistream to replace, found " +
                           "another file; choose another name, or remove that file");
        EXPECT_EQ(text_of(folder / name), before);
    }
}

/// A frame of another size ends the trial, and the coding with what came before kept.
TEST_F(Programs, EncodeKeepsWhatCameBeforeAFrameOfAnotherShape) {
    render("r/centre", 96, 64, 0, 3);
    render("r/centre", 64, 96, 4, 5);
    expect_failure(run("encode '" + path("r") + "' --preset veryfast --out '" + path("a.mkv") + "'"), 1,
                   "what was coded so far is kept in");
    EXPECT_TRUE(fs::exists(folder / "a.mkv.part"));
}

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
        EXPECT_EQ(picture.info->visible_loss.has_value(), main);
        expected.visible_loss = picture.info->visible_loss;
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

/// What tiles show, put together again, by frame.
std::map<std::int64_t, ByteImage> spheres_of(const std::string& file, const WindowGrid& grid) {
    std::map<std::int64_t, ByteImage> spheres;
    StreamReader reader(file);
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        if (picture.role != TrackRole::window)
            continue;
        const auto place = window_place(grid, std::get<EquirectCamera>(picture.info.value().camera).range).value();
        ByteImage& sphere = spheres.try_emplace(picture.info->index, grid.columns, grid.rows, 3).first->second;
        for (int y = 0; y < picture.height; ++y)
            std::copy_n(picture.rgb.pixel(0, y), 3 * picture.width, sphere.pixel(place.x, place.y + y));
    }
    EXPECT_EQ(reader.truncation(), "");
    return spheres;
}

TEST_F(Programs, TilesShowWhatTheWholeSphereDoes) {
    render("r/centre", 512, 256, 3, 5);
    for (std::int64_t index = 3; index <= 5; ++index) {
        Frame frame = read_exr(folder / "r/centre" / frame_file_name(index));
        FloatImage& depth_m = frame.planes.emplace("depth", FloatImage(512, 256, 1, 2.0f)).first->second;
        std::fill_n(depth_m.pixel(0, 64), 64 * 512, 5.0f);  // the second row of tiles
        write_exr(folder / "r/centre" / frame_file_name(index), frame);
    }
    const std::string words =
        "encode '" + path("r") + "' --preset ultrafast --gop 2 --json --depth-crf 14 --depth-scale 1 --depth ";
    ASSERT_EQ(run(words + "w10 --out '" + path("whole.mkv") + "'").status, 0);
    StreamReader reader(path("whole.mkv"));
    std::map<std::int64_t, double> whole_psnr_db;
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        if (picture.role == TrackRole::main)
            whole_psnr_db[picture.info->index] =
                synthetic::psnr_db(picture.rgb, synthetic::picture(512, 256, picture.info->index));
    for (const auto& [depth, file] :
         {std::pair("w10", path("a.mkv")), {"w10", path("a.mp4")}, {"w12", path("b.mp4")}}) {  // w12 is H.265
        const Ran ran = run(words + depth + " --out '" + file + "' --tiles 8x4");
        ASSERT_EQ(ran.status, 0) << ran.errors;
        std::map<std::string, std::vector<int>> tracks;
        const auto report = nlohmann::json::parse(ran.output);
        for (const auto& track : report["tracks"])
            tracks[track["name"]] = {track["tiles"], track["width"], track["height"]};
        EXPECT_EQ(tracks, (std::map<std::string, std::vector<int>>{{"main", {1, 128, 64}},
                                                                   {"depth", {1, 128, 64}},
                                                                   {"window", {32, 64, 64}},
                                                                   {"window-depth", {32, 64, 64}}}));
        EXPECT_EQ(report["tracks"].size(), 4u) << "one entry for all tiles";
        const auto spheres = spheres_of(file, {512, 256, 64, 64});
        ASSERT_EQ(spheres.size(), 3u);
        for (const auto& [index, sphere] : spheres)
            EXPECT_GT(synthetic::psnr_db(sphere, synthetic::picture(512, 256, index)), whole_psnr_db[index] - 1);
        StreamReader tiles(file);
        for (const DecodedPicture& picture : synthetic::read_all(tiles)) {
            const bool second_row = picture.track / 2 >= 9 && picture.track / 2 < 17;
            if (picture.role == TrackRole::main) {
                EXPECT_GT(synthetic::psnr_db(picture.rgb, synthetic::picture(128, 64, picture.info->index)), 30);
            } else if (picture.role == TrackRole::depth) {
                EXPECT_NEAR(*picture.depth_m.pixel(50, 20), 5, 0.2);
            } else if (picture.role == TrackRole::window_depth) {
                EXPECT_NEAR(*picture.depth_m.pixel(50, 20), second_row ? 5 : 2, 0.2) << picture.track;
            }
        }
    }
    const Ran text =
        run("encode '" + path("r") + "' --preset ultrafast --tiles 2x1 --base 256 --out '" + path("b.mkv") + "'");
    EXPECT_NE(text.output.find("2 tiles of 256x256"), std::string::npos) << text.output << text.errors;
    EXPECT_EQ(StreamReader(path("b.mkv")).tracks().front().width, 256);
}

/// H.264 beside H.265, which reorder by other numbers of pictures.
TEST_F(Programs, PicturesOfBothCodecsComeAtTheSameTimes) {
    render("r/centre", 128, 64, 0, 7);
    for (std::int64_t index = 0; index <= 7; ++index) {
        Frame frame = read_exr(folder / "r/centre" / frame_file_name(index));
        frame.planes["depth"] = FloatImage(128, 64, 1, 2.0f);
        write_exr(folder / "r/centre" / frame_file_name(index), frame);
    }
    for (const std::string preset : {"ultrafast", "medium", "veryslow"})
        for (const int gop : {1, 2, 3, 30})
            for (const std::string container : {".mp4", ".mkv"}) {
                const std::string file = path("a" + container);
                const std::string words = " --depth w12 --preset " + preset + " --gop " + std::to_string(gop);
                ASSERT_EQ(run("encode '" + path("r") + "' --out '" + file + "'" + words).status, 0);
                StreamReader reader(file);
                std::map<int, std::vector<std::int64_t>> shown;
                while (const auto picture = reader.next())
                    shown[int(picture->role)].push_back(picture->info->index);
                const std::vector<std::int64_t> all = {0, 1, 2, 3, 4, 5, 6, 7};
                EXPECT_EQ(shown, (std::map<int, std::vector<std::int64_t>>{{int(TrackRole::main), all},
                                                                           {int(TrackRole::depth), all}}));
                for (const auto& track : reader.tracks())
                    EXPECT_NEAR(track.frames_per_second, 30, 0.01) << file << words << ", " << track_name(track.role);
                EXPECT_EQ(reader.truncation(), "");
            }
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
    // A disk that fills up on the way, for anybody who runs this: files may have 32 KiB from here on.
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{32 * 1024, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    const Ran ran = run("encode '" + path("r") + "' --crf 0 --out '" + path("a.mkv") + "'");
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &before), 0);
    expect_failure(ran, 1, "File too large; what was coded so far is kept in");
    EXPECT_FALSE(fs::exists(folder / "a.mkv"));
    EXPECT_GT(fs::file_size(folder / "a.mkv.part"), 0u);
}

/// JSON holds UTF-8 alone; a folder's name may be any bytes.
TEST_F(Programs, ANameThatIsNotUtf8IsReported) {
    const std::string name = "r\xff";
    render(name, 96, 64, 0, 1);
    const Ran ran =
        run("encode '" + path(name) + "' --preset ultrafast --json --progress json --out '" + path("a\xff.mkv") + "'");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    EXPECT_NE(nlohmann::json::parse(ran.output).dump().find("a\xef\xbf\xbd.mkv"), std::string::npos) << ran.output;
    EXPECT_TRUE(fs::exists(path("a\xff.mkv")));
}

}  // namespace

// Both eyes as one ordinary video.

namespace {

namespace fs = std::filesystem;

ByteImage half(const ByteImage& both, bool second, bool beside) {
    const int width = beside ? both.width() / 2 : both.width(), height = beside ? both.height() : both.height() / 2;
    ByteImage one(width, height, 3);
    for (int y = 0; y < height; ++y)
        std::copy_n(both.pixel(second && beside ? width : 0, second && !beside ? y + height : y), 3 * width,
                    one.pixel(0, y));
    return one;
}

/// The right eye's pictures are those that the left one will see ten frames later.
TEST_F(Programs, BothEyesGoIntoOneOrdinaryVideo) {
    constexpr std::int64_t ahead = 10;
    render("r/left", 192, 96, 3, 6, Eye::left);
    render("r/right", 192, 96, 3, 6, Eye::right, 1000, ahead);
    for (const bool beside : {false, true}) {
        const std::string how = beside ? "side-by-side" : "top-bottom";
        for (const std::string type : {".mp4", ".mkv"}) {
            const Ran ran = run("encode '" + path("r") + "' --stereo " + how +
                                " --preset veryfast --crf 12 --json --out '" + path(how + type) + "'");
            ASSERT_EQ(ran.status, 0) << ran.errors;
            const auto report = nlohmann::json::parse(ran.output);
            EXPECT_EQ(report["stereo"], how);
            ASSERT_EQ(report["tracks"].size(), 1u);
            EXPECT_EQ(report["tracks"][0]["width"], beside ? 384 : 192);
            EXPECT_EQ(report["tracks"][0]["height"], beside ? 96 : 192);
            EXPECT_TRUE(report["sphere_tag"]);
            StreamReader reader(path(how + type));
            EXPECT_EQ(reader.tracks().front().stereo, beside ? StereoPacking::side_by_side : StereoPacking::top_bottom);
            EXPECT_TRUE(reader.tracks().front().sphere);
            const auto pictures = synthetic::read_all(reader);
            ASSERT_EQ(pictures.size(), 4u);
            for (std::size_t i = 0; i < pictures.size(); ++i) {
                EXPECT_FALSE(pictures[i].info) << "no one camera took it";
                const ByteImage left = synthetic::picture(192, 96, std::int64_t(i) + 3),
                                right = synthetic::picture(192, 96, std::int64_t(i) + 3 + ahead);
                EXPECT_LT(synthetic::psnr_db(left, right), 20);
                EXPECT_GT(synthetic::psnr_db(half(pictures[i].rgb, false, beside), left), 36);
                EXPECT_GT(synthetic::psnr_db(half(pictures[i].rgb, true, beside), right), 36);
            }
        }
    }
}

/// Rendered of one head, they carry its pose, and each its own depth.
TEST_F(Programs, BothEyesCarryTheirPosesAndDepth) {
    for (const Eye eye : {Eye::left, Eye::right}) {
        const std::string name = eye == Eye::left ? "r/left" : "r/right";
        render(name, 192, 96, 0, 2, eye);
        for (std::int64_t index = 0; index <= 2; ++index) {
            const fs::path file = folder / name / frame_file_name(index);
            Frame frame = read_exr(file);
            frame.info.camera_pose =
                camera_pose(frame.info.camera, frame.info.head, eye, frame.info.ipd_m, frame.info.lock);
            frame.planes.emplace("depth", FloatImage(192, 96, 1, eye == Eye::left ? 2.0f : 1.5f));
            write_exr(file, frame);
        }
    }
    const Ran ran = run("encode '" + path("r") +
                        "' --stereo top-bottom --depth w12 --depth-crf 4 --preset veryfast --json "
                        "--out '" +
                        path("a.mp4") + "'");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    const auto report = nlohmann::json::parse(ran.output);
    EXPECT_TRUE(report["posed"]);
    ASSERT_EQ(report["tracks"].size(), 2u);
    EXPECT_NE(run("info '" + path("a.mp4") + "'").output.find("63.0 mm between the eyes"), std::string::npos);
    const auto described = nlohmann::json::parse(run("info '" + path("a.mp4") + "' --json").output);
    EXPECT_EQ(described["tracks"][0]["stereo"], "top-bottom");
    EXPECT_TRUE(described["tracks"][0]["vexu"]);
    EXPECT_NEAR(described["tracks"][0]["baseline_m"].get<double>(), 0.063, 1e-6);
    EXPECT_EQ(described["tracks"][0]["first_frame"]["packing"], "top-bottom");
    StreamReader reader(path("a.mp4"));
    int depths = 0;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        ASSERT_TRUE(picture.info);
        EXPECT_EQ(picture.info->packing, StereoPacking::top_bottom);
        EXPECT_EQ(picture.info->eye, Eye::left);
        EXPECT_EQ(picture_height(*picture.info), 192);
        EXPECT_LT(glm::distance(right_eye_of(*picture.info).camera_pose.position_m,
                                eye_position(picture.info->head, Eye::right, 0.063)),
                  1e-12);
        if (picture.depth_m.empty())
            continue;
        ++depths;
        // The right eye's is nearer, and within the range too.
        EXPECT_NEAR(*picture.depth_m.pixel(100, 20), 2.0f, 0.01);
        EXPECT_NEAR(*picture.depth_m.pixel(100, 120), 1.5f, 0.01);
    }
    EXPECT_EQ(depths, 3);
}

/// Clients only turn it, each eye its own.
TEST_F(Programs, OmnidirectionalStereoIsOfBothEyesAndWithoutDepth) {
    for (const Eye eye : {Eye::left, Eye::right}) {
        const std::string name = eye == Eye::left ? "r/left" : "r/right";
        render(name, 96, 64, 0, 1, eye);
        for (std::int64_t index = 0; index <= 1; ++index) {
            const fs::path file = folder / name / frame_file_name(index);
            Frame frame = read_exr(file);
            std::get<EquirectCamera>(frame.info.camera).ods_side_m = ods_side_m(eye, frame.info.ipd_m);
            frame.planes.emplace("depth", FloatImage(96, 64, 1, 2.0f));
            write_exr(file, frame);
        }
    }
    const std::string out = "' --preset ultrafast --out '" + path("a.mp4") + "'";
    expect_failure(run("encode '" + path("r") + out), 2, "omnidirectional stereo needs both eyes");
    expect_failure(run("encode '" + path("r") + out + " --stereo top-bottom --depth auto"), 2,
                   "omnidirectional stereo, which clients turn without depth");
    const Ran ran = run("encode '" + path("r") + out + " --stereo top-bottom");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    StreamReader reader(path("a.mp4"));
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        ASSERT_TRUE(picture.info);
        EXPECT_EQ(std::get<EquirectCamera>(picture.info->camera).ods_side_m, -0.0315);
        EXPECT_EQ(std::get<EquirectCamera>(right_eye_of(*picture.info).camera).ods_side_m, 0.0315);
    }
    EXPECT_NE(run("info '" + path("a.mp4") + "'").output.find("omnidirectional stereo"), std::string::npos);
}

TEST_F(Programs, TheLeftEyeIsAboveTheRightOne) {
    render("r/left", 64, 64, 0, 0, Eye::left);
    render("other", 64, 64, 7, 7, Eye::right);
    fs::create_directories(folder / "r/right");
    // Frame 7's colours as frame 0 of the right eye.
    Frame frame = read_exr(folder / "other" / frame_file_name(7));
    frame.info = info(64, 64, 0, Eye::right);
    write_exr(folder / "r/right" / frame_file_name(0), frame);
    ASSERT_EQ(run("encode '" + path("r") + "' --stereo top-bottom --crf 4 --out '" + path("a.mkv") + "'").status, 0);
    StreamReader reader(path("a.mkv"));
    const auto picture = reader.next();
    ASSERT_TRUE(picture);
    EXPECT_GT(synthetic::psnr_db(half(picture->rgb, false, false), synthetic::picture(64, 64, 0)), 36);
    EXPECT_GT(synthetic::psnr_db(half(picture->rgb, true, false), synthetic::picture(64, 64, 7)), 36);
    EXPECT_LT(synthetic::psnr_db(half(picture->rgb, true, false), synthetic::picture(64, 64, 0)), 30);
}

TEST_F(Programs, TheEyeThatIsLeftOutIsNamed) {
    render("r/left", 64, 64, 0, 1, Eye::left);
    render("r/right", 64, 64, 0, 1, Eye::right);
    const std::string encode = "encode '" + path("r") + "' --preset ultrafast --out '" + path("a.mkv") + "' ";
    const Ran text = run(encode);
    ASSERT_EQ(text.status, 0) << text.errors;
    EXPECT_NE(text.output.find("right/ is not encoded: clients make both eyes from " + path("r/left") +
                               " by depth (--eye right encodes that instead, --stereo top-bottom both"),
              std::string::npos)
        << text.output;
    const auto left_out = [&](const std::string& more) {
        return nlohmann::json::parse(run(encode + "--json " + more).output)["left_out"];
    };
    EXPECT_EQ(left_out(""), nlohmann::json({"right"}));
    EXPECT_EQ(left_out("--eye right"), nlohmann::json({"left"}));
    EXPECT_EQ(left_out("--stereo top-bottom"), nlohmann::json::array());
    EXPECT_EQ(nlohmann::json::parse(
                  run("encode '" + path("r/left") + "' --preset ultrafast --json --out '" + path("a.mkv") + "'")
                      .output)["left_out"],
              nlohmann::json::array());
}

TEST_F(Programs, BothEyesMustBeThereAndBelongTogether) {
    render("r/left", 64, 64, 0, 1, Eye::left);
    const std::string words = "encode '" + path("r") + "' --out '" + path("a.mkv") + "' --stereo top-bottom";
    expect_failure(run(words), 2, "r/right: expected frame.NNNN.exr files of that eye (render --eye both), found none");
    render("r/right", 64, 64, 0, 0, Eye::right);
    expect_failure(run(words), 2, "r/right: expected frames 0-1");
    render("r/right", 64, 66, 0, 1, Eye::right);
    expect_failure(run(words), 2, "expected the left eye's size, 64x64, found 64x66");
    render("r/right", 64, 64, 0, 1, Eye::right, 5);
    expect_failure(run(words), 2, "expected the seed of " + path("r/left"));
    render("r/right", 64, 64, 0, 1, Eye::right);
    EXPECT_EQ(run(words).status, 0);
    expect_failure(run(words + " --depth auto"), 2, "expected plane depth");
    for (const std::string more : {"--eye left", "--fill small", "--mirrors always"})
        expect_failure(run(words + " " + more), 2, "expected only both eyes and their depth, found " + more);
}

}  // namespace
}  // namespace equistream::test
