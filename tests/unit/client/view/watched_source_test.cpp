/// What a viewer opens of a stream: all that it may come to show, and geometry only of what was rendered.
#include "frames_folder.h"

#include <client/view/watched_source.h>

#include <equistream/error.h>
#include <equistream/stream.h>

#include <filesystem>
#include <string>

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

}  // namespace
}  // namespace equistream::test
