/// What equistream-info says of streams, frames, folders and of what is none of these.
#include <tests/unit/programs/programs_fixture.h>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace equistream::test {
namespace {

namespace fs = std::filesystem;

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

TEST_F(Programs, InfoDrawsEveryFolderOfARender) {
    render("r/centre", 64, 32, 0, 1);
    render("r/hidden", 64, 32, 0, 1);
    const Ran ran = run("info '" + path("r") + "' --pictures '" + path("look") + "'");
    ASSERT_EQ(ran.status, 0) << ran.errors;
    EXPECT_TRUE(ran.output.ends_with("\n" + path("look") + ": 4 pictures written\n")) << ran.output;
    for (const char* picture : {"centre/frame.0000.colour.png", "centre/frame.0001.colour.png",
                                "hidden/frame.0000.colour.png", "hidden/frame.0001.colour.png"})
        EXPECT_TRUE(fs::exists(folder / "look" / picture)) << picture;
    ASSERT_EQ(run("info '" + path("r/centre") + "' --pictures '" + path("one") + "'").status, 0);
    EXPECT_TRUE(fs::exists(folder / "one/frame.0001.colour.png"));
}

TEST_F(Programs, InfoLeavesNoFolderWhereThereIsNothingToDraw) {
    fs::create_directories(folder / "empty");
    synthetic::write(folder / "a.mkv", synthetic::small_stream(Codec::h264, false));
    expect_failure(run("info '" + path("empty") + "' --pictures '" + path("look") + "'"), 2, "found none");
    expect_failure(run("info '" + path("a.mkv") + "' --pictures '" + path("look") + "'"), 2,
                   "--pictures: expected an EXR frame or a folder of frames, found ");
    EXPECT_FALSE(fs::exists(folder / "look"));
}

TEST_F(Programs, InfoReadsAPipe) {
    synthetic::write(folder / "a.ts", synthetic::small_stream(Codec::h264, false));
    const Ran ran = run("info pipe:0", path("a.ts"));
    EXPECT_EQ(ran.status, 0) << ran.errors;
    EXPECT_NE(ran.output.find("track main: h264, 192x96"), std::string::npos) << ran.output;
}

TEST_F(Programs, InfoWaitsForNoNamedPipe) {
    ASSERT_EQ(mkfifo(path("pipe").c_str(), 0600), 0);
    for (const char* options : {"", "--pictures '/dev/null/none' "})
        expect_failure(run("info " + std::string(options) + "'" + path("pipe") + "'"), 2,
                       "pipe: expected a file, a folder or a URL, found a named pipe or a device (info pipe:0 reads "
                       "standard input)");
    expect_failure(run("info /dev/zero"), 2, "found a named pipe or a device");
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which reserve more than any limit
TEST_F(Programs, InfoTakesLittleMemoryForALargePictureInASmallFile) {
    constexpr int width = 12288, height = 4096;
    {
        Frame frame;
        frame.info = info(width, height, 0, Eye::centre);
        frame.planes.emplace("colour", FloatImage(width, height, 4, 0.0f));
        write_exr(folder / "black.exr", frame);
    }
    ASSERT_LT(fs::file_size(folder / "black.exr"), 4u << 20);
    constexpr int limit_kib = 700'000;
    static_assert(std::int64_t{width} * height * 4 * sizeof(float) > std::int64_t{limit_kib} * 1024);
    const Ran ran = run_line("(ulimit -v " + std::to_string(limit_kib) +
                             "; MALLOC_ARENA_MAX=1 " EQUISTREAM_BIN "/equistream-info '" + path("black.exr") + "')");
    EXPECT_EQ(ran.status, 0) << ran.errors;
    EXPECT_NE(ran.output.find("part rgba: 12288x4096"), std::string::npos) << ran.output;
}

/// Whose tables of patches are as large as they may be.
void write_patches(const std::filesystem::path& file, std::int64_t frames) {
    constexpr int width = 128, height = 64;
    StreamSettings settings;
    settings.codec = Codec::h264;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, width, height}, {TrackRole::patches, width, height}};
    StreamWriter writer(file.string(), settings);
    FrameInfo info = synthetic::info(width, height, 0);
    PatchAtlas atlas;
    atlas.sphere_width = width;
    atlas.sphere_height = height;
    atlas.offsets_m = {{0.02, 0, 0}};
    atlas.block_side = min_patch_side;
    atlas.columns = 128;
    atlas.rows = max_patch_slots / atlas.columns;
    atlas.slots.resize(std::size_t(max_patch_slots));
    const ByteImage picture = synthetic::picture(width, height, 0);
    for (info.index = 0; info.index < frames; ++info.index) {
        info.time_s = double(info.index) / 30;
        info.patches.reset();
        writer.write(TrackRole::main, picture.view(), info);
        info.patches = atlas;
        writer.write(TrackRole::patches, picture.view(), info);
    }
    writer.finish();
}

/// The most memory that info took. What posix_spawn() starts would begin with the peak of this process.
long info_peak_kib(const std::string& file) {
    const pid_t child = fork();
    if (child == 0) {
        dup2(open("/dev/null", O_WRONLY | O_CLOEXEC), STDOUT_FILENO);
        execl(EQUISTREAM_BIN "/equistream-info", "equistream-info", file.c_str(), nullptr);
        _exit(127);
    }
    int status = 0;
    rusage usage{};
    EXPECT_EQ(wait4(child, &status, 0, &usage), child);
    EXPECT_EQ(status, 0);
    return usage.ru_maxrss;
}

TEST_F(Programs, InfoTakesNoMoreMemoryForALongStream) {
    write_patches(folder / "short.mkv", 40);
    write_patches(folder / "long.mkv", 1040);
    const Ran ran = run("info '" + path("short.mkv") + "'");
    EXPECT_NE(ran.output.find("track patches: "), std::string::npos) << ran.output;
    constexpr long kib_of_tables = 1000 * max_patch_slots * long(sizeof(PatchAtlas::Slot)) / 1024;
    EXPECT_LT(info_peak_kib(path("long.mkv")), info_peak_kib(path("short.mkv")) + kib_of_tables / 4);
}
#endif

TEST_F(Programs, InfoListsTheFramesOfTheFirstTileAlone) {
    const synthetic::MadeTiles made{.pictures = 3};
    synthetic::write(folder / "tiles.mkv", made);
    const auto tracks = nlohmann::json::parse(run("info --json --frames '" + path("tiles.mkv") + "'").output)["tracks"];
    ASSERT_EQ(tracks.size(), 2u);
    EXPECT_EQ(tracks[1]["tiles"], made.grid.count());
    EXPECT_EQ(tracks[1]["pictures"], made.grid.count() * made.pictures);
    EXPECT_EQ(tracks[1]["frames"].size(), std::size_t(made.pictures));
    const Ran text = run("info --frames '" + path("tiles.mkv") + "'");
    const std::string line = "\n  frame ";
    std::size_t lines = 0;
    for (std::size_t at = 0; (at = text.output.find(line, at)) != std::string::npos; ++at)
        ++lines;
    EXPECT_EQ(lines, std::size_t(2 * made.pictures)) << text.output;
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
}  // namespace equistream::test
