/// Ordinary players must play what we write: FFmpeg's own tools and mpv, each in a process of its own. Left out, and
/// said so, where a player is not installed.
#include "synthetic.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace equistream {
namespace {

struct Ran {
    int status;
    std::string output;
};

/// Runs a shell command; standard output and error together.
Ran run(const std::string& command) {
    FILE* pipe = popen((command + " 2>&1 </dev/null").c_str(), "r");
    Ran ran{-1, ""};
    std::array<char, 4096> part;
    while (const std::size_t size = std::fread(part.data(), 1, part.size(), pipe))
        ran.output.append(part.data(), size);
    ran.status = pclose(pipe);
    return ran;
}

bool is_installed(const std::string& program) {
    return run("command -v " + program).status == 0;
}

struct Case {
    const char* name;
    Codec codec;
    bool two_tracks;
};

class Players : public testing::TestWithParam<Case> {
protected:
    void SetUp() override {
        made = synthetic::small_stream(GetParam().codec, GetParam().two_tracks);
        synthetic::write(file(), made);
    }
    std::string file() const { return (folder / GetParam().name).string(); }

    synthetic::Folder folder;
    synthetic::Made made;
};

TEST_P(Players, FfmpegPlaysEveryTrackWithoutAWord) {
    ASSERT_TRUE(is_installed("ffmpeg")) << "ffmpeg is not installed; ./test installs it";
    const Ran ran = run("ffmpeg -v warning -xerror -i '" + file() + "' -map 0:v -f null -");
    EXPECT_EQ(ran.status, 0);
    EXPECT_EQ(ran.output, "");
}

TEST_P(Players, FfprobeReadsTheColourTags) {
    ASSERT_TRUE(is_installed("ffprobe")) << "ffprobe is not installed; ./test installs it";
    const Ran ran = run("ffprobe -v error -select_streams v:0 -count_frames -show_entries "
                        "stream=width,height,pix_fmt,color_range,color_space,color_transfer,color_primaries,"
                        "chroma_location,nb_read_frames -of default=nw=1 '" +
                        file() + "'");
    for (const char* line :
         {"width=192", "height=96", "pix_fmt=yuv420p", "color_range=tv", "color_space=bt709",
          "color_transfer=iec61966-2-1", "color_primaries=bt709", "chroma_location=left", "nb_read_frames=12"})
        EXPECT_NE(ran.output.find(line), std::string::npos) << line << "\n" << ran.output;
}

TEST_P(Players, MpvPlays) {
    ASSERT_TRUE(is_installed("mpv")) << "mpv is not installed; ./test installs it";
    // Raw video has no timestamps, which mpv warns of; errors count everywhere.
    const std::string level = file().ends_with(".h264") || file().ends_with(".h265") ? "error" : "warn";
    const Ran ran = run("mpv --no-config --vo=null --ao=null --untimed --msg-level=all=" + level + " '" + file() + "'");
    EXPECT_EQ(ran.status, 0);
    EXPECT_EQ(ran.output, "");
}

INSTANTIATE_TEST_SUITE_P(Stream, Players,
                         testing::Values(Case{"a.mp4", Codec::h264, true}, Case{"a.mp4", Codec::h265, true},
                                         Case{"a.mkv", Codec::h264, true}, Case{"a.mkv", Codec::h265, true},
                                         Case{"a.ts", Codec::h264, true}, Case{"a.ts", Codec::h265, true},
                                         Case{"a.nut", Codec::h264, true}, Case{"a.nut", Codec::h265, true},
                                         Case{"a.h264", Codec::h264, false}, Case{"a.h265", Codec::h265, false}),
                         [](const auto& test) {
                             std::string name =
                                 test.param.name + std::string(test.param.codec == Codec::h264 ? "_h264" : "_h265");
                             std::erase(name, '.');
                             return name;
                         });

TEST(SphericalMetadata, IsWhatPlayersLookFor) {
    ASSERT_TRUE(is_installed("ffprobe")) << "ffprobe is not installed; ./test installs it";
    for (const char* name : {"a.mp4", "a.mkv"}) {
        synthetic::Folder folder;
        synthetic::write(folder / name, synthetic::small_stream(Codec::h264, true));
        const Ran ran = run("ffprobe -v error -select_streams v:0 -show_streams '" + (folder / name).string() + "'");
        EXPECT_NE(ran.output.find("side_data_type=Spherical Mapping"), std::string::npos) << ran.output;
        EXPECT_NE(ran.output.find("projection=equirectangular"), std::string::npos) << ran.output;
    }
}

TEST(ForeignVideo, PlaysWithoutFrameInfo) {
    ASSERT_TRUE(is_installed("ffmpeg")) << "ffmpeg is not installed; ./test installs it";
    const std::array<const char*, 3> videos[] = {
        {"a.mp4", "322x124", "-c:v libx264 -pix_fmt yuv420p"},
        {"b.mkv", "321x123", "-c:v mjpeg -pix_fmt yuvj422p"},
        {"c.avi", "321x123", "-c:v mpeg4"},
        {"d.mkv", "321x123", "-c:v ffv1 -pix_fmt yuv444p10le"},
        {"e.webm", "321x123", "-c:v libvpx -pix_fmt yuv420p"},
    };
    for (const auto& [name, size, options] : videos) {
        synthetic::Folder folder;
        const std::string file = (folder / name).string();
        const Ran ran = run("ffmpeg -v error -f lavfi -i color=c=0x4080c0:s=" + std::string(size) +
                            ":r=25 -frames:v 7 " + options + " '" + file + "'");
        ASSERT_EQ(ran.output, "") << name;
        StreamReader reader(file);
        const auto pictures = synthetic::read_all(reader);
        EXPECT_EQ(pictures.size(), 7u) << name;
        EXPECT_EQ(reader.truncation(), "") << name;
        for (const DecodedPicture& picture : pictures) {
            EXPECT_FALSE(picture.info);
            const std::uint8_t expected[] = {0x40, 0x80, 0xc0};
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(picture.rgb.pixel(50, 50)[c], expected[c], 6) << name;
        }
    }
}

}  // namespace
}  // namespace equistream
