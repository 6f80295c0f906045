/// What a viewer opens of a stream: all that it may come to show, and geometry only of what was rendered.
#include "frames_folder.h"

#include <client/view/watched_source.h>

#include <equistream/error.h>
#include <equistream/stream.h>

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

class WatchedSources : public FramesFolder {
protected:
    void SetUp() override {
        FramesFolder::SetUp();
        for (int index = 0; index < frame_count; ++index) {
            const std::filesystem::path file = folder / "centre" / frame_file_name(index);
            Frame frame = read_exr(file);
            frame.planes["depth"] = FloatImage(32, 16, 1, 3.0f);
            write_exr(file, frame);
        }
    }
    static ViewerSettings settings(const std::filesystem::path& source) {
        ViewerSettings settings;
        settings.source = source.string();
        settings.upload = PictureUpload::copied;  // there is no context
        settings.hardware = false;
        return settings;
    }
};

TEST_F(WatchedSources, GeometryOfAnotherSceneIsRefused) {
    ViewerSettings with_scene = settings(folder);
    with_scene.scene.emplace();
    with_scene.scene->file = "hall.json";
    with_scene.scene->name = "hall";
    try {
        const WatchedSource source(with_scene, {});
        ADD_FAILURE() << "the frames are of no hall";
    } catch (const InputError& error) {
        EXPECT_EQ(std::string(error.what()).rfind("hall.json: expected the scene '' that ", 0), 0U) << error.what();
    }
    with_scene.scene->name.clear();
    EXPECT_NE(WatchedSource(with_scene, {}).note, "") << "these frames do not name their geometry";
}

TEST_F(WatchedSources, MirrorsOnTheirSurfaceAreKnownWhereGapsOrConfidenceAsk) {
    const std::filesystem::path file = folder / "mirrors.mkv";
    StreamSettings coded;
    coded.preset = "ultrafast";
    coded.tracks = {{TrackRole::main, 128, 64}, {TrackRole::reflections, 128, 64, DepthCodeId::w10}};
    const FloatImage image_m(128, 64, 1, 2.0f);
    StreamWriter writer(file.string(), coded);
    for (std::int64_t index = 0; index < 2; ++index) {
        FrameInfo info;
        info.index = index;
        info.time_s = double(index) / 30;
        info.camera = EquirectCamera{128, 64, {}};
        writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), info);
        info.depth_code = DepthCodeInfo{DepthCodeId::w10, {0.0315, 1, true}, 0};
        writer.write_depth(TrackRole::reflections, image_m.view(), info);
    }
    writer.finish();
    struct Case {
        const char* chain;
        gl::Overlay overlay;
        bool asks;
    };
    for (const Case& each :
         {Case{default_fill, gl::Overlay::none, true}, Case{"pushpull", gl::Overlay::reliability, true},
          Case{"pushpull", gl::Overlay::none, false}}) {
        ViewerSettings painted = settings(file);
        painted.shown.mirrors = MirrorTreatment::surface;
        painted.shown.fill_chain = each.chain;
        painted.shown.overlay = each.overlay;
        WatchedSource source(painted, {});
        EXPECT_EQ(!waited_for(source.loader)->main.specular.empty(), each.asks) << each.chain;
    }
}

class Lengths : public WatchedSources {
protected:
    /// Frames of these numbers, 30 a second.
    std::filesystem::path write(const char* name, const std::vector<std::int64_t>& numbers) const {
        const std::filesystem::path file = folder / name;
        StreamSettings coded;
        coded.preset = "ultrafast";
        coded.gop = 1;
        coded.tracks = {{TrackRole::main, 128, 64}};
        StreamWriter writer(file.string(), coded);
        for (const std::int64_t number : numbers) {
            FrameInfo info;
            info.index = number;
            info.time_s = double(number) / 30;
            info.camera = EquirectCamera{128, 64, {}};
            info.host = "test";
            writer.write(TrackRole::main, ByteImage(128, 64, 3, 99).view(), info);
        }
        writer.finish();
        return file;
    }
    /// Of a file in another box that holds nothing: as large as a long recording.
    static void make_large(const std::filesystem::path& file) {
        constexpr std::array<unsigned char, 16> box = {0, 0, 0, 1, 'f', 'r', 'e', 'e', 0, 0, 0, 0, 0x90, 0, 0, 0};
        const std::uintmax_t bytes = std::filesystem::file_size(file);
        std::ofstream(file, std::ios::binary | std::ios::app)
            .write(reinterpret_cast<const char*>(box.data()), std::streamsize(box.size()));
        std::filesystem::resize_file(file, bytes + 0x90000000);
    }
    static double length_once_known(const WatchedSource& source) {
        for (int i = 0; i < 20000 && source.seconds() == 0; ++i)
            doze();
        return source.seconds();
    }
};

/// However few frames a second come before it, the last one is shown as long as its number is.
TEST_F(Lengths, OfFragmentsAreFoundWhateverTheSize) {
    const std::filesystem::path file = write("sparse.mp4", {0, 15, 30});
    EXPECT_NEAR(length_once_known(WatchedSource(settings(file), {})), 31 / 30.0, 0.002);
    make_large(file);
    EXPECT_NEAR(length_once_known(WatchedSource(settings(file), {})), 31 / 30.0, 0.002);
}

TEST_F(Lengths, AreNotLookedForWhereTheContainerSaysThem) {
    const std::filesystem::path file = write("finished.mkv", {0, 1, 2});
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(bytes), {}};
    const std::size_t duration = text.find("\x44\x89\x88");  // 8 bytes: milliseconds
    ASSERT_NE(duration, std::string::npos);
    constexpr std::array<unsigned char, 8> ms_99000 = {0x40, 0xf8, 0x2b, 0x80, 0, 0, 0, 0};
    bytes.clear();
    bytes.seekp(std::streamoff(duration + 3));
    bytes.write(reinterpret_cast<const char*>(ms_99000.data()), std::streamsize(ms_99000.size()));
    bytes.close();
    const WatchedSource source(settings(file), {});
    for (int i = 0; i < 200; ++i)
        doze();
    EXPECT_EQ(source.seconds(), 99);
}

}  // namespace
}  // namespace equistream::test
