/// Where a live stream's groups begin, how coarse its pictures are, and that it keeps no frames.
#include <equistream/sequence.h>
#include <equistream/window.h>
#include <plugin/stream/libav.h>
#include <programs/serve/live_encoder.h>
#include <tests/unit/plugin/stream/synthetic.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace equistream::serve {
namespace {

/// What a renderer leaves: all of it 10 m away but for one pixel.
std::string rendered(const std::filesystem::path& file, const FrameInfo& info, float nearest_m) {
    const int width = width_of(info.camera), height = height_of(info.camera);
    Frame frame;
    frame.info = info;
    frame.planes["colour"] = FloatImage(width, height, 4, 0.2f);
    frame.planes["depth"] = FloatImage(width, height, 1, 10.0f);
    *frame.planes["depth"].pixel(50, 40) = nearest_m;
    write_exr(file, frame);
    return file.string();
}
std::string rendered(const synthetic::Folder& folder, std::int64_t index, float nearest_m) {
    return rendered(folder / "frame.exr", synthetic::info(192, 96, index), nearest_m);
}

LiveCoding quick() {
    LiveCoding coding;
    coding.crf = 20;
    coding.preset = "ultrafast";
    return coding;
}

/// By role and index, of a whole stream's pictures.
std::map<std::pair<TrackRole, std::int64_t>, float> coded_with(const synthetic::Folder& folder,
                                                               const std::string& stream) {
    std::ofstream(folder / "a.mkv", std::ios::binary) << stream;
    StreamReader reader((folder / "a.mkv").string());
    std::map<std::pair<TrackRole, std::int64_t>, float> crf;
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        crf[{picture.role, picture.info->index}] = picture.info->crf.value();
    EXPECT_EQ(reader.truncation(), "");
    return crf;
}

TEST(LiveEncoders, BeginGroupsWhereTheyMustAndKeepNoFrames) {
    const synthetic::Folder folder;
    LiveEncoder encoder(quick());
    EXPECT_EQ(encoder.finish(), "") << "there was no frame";
    std::string all;
    const auto begins = [&](std::int64_t index, float nearest_m, bool asked, double coarser = 0) {
        const auto coded = encoder.encode(rendered(folder, index, nearest_m), "", asked, coarser, double(index) / 30);
        EXPECT_FALSE(std::filesystem::exists(folder / "frame.exr")) << "a server may run for weeks";
        EXPECT_EQ(coded.header.empty(), index > 0);
        EXPECT_EQ(coded.coarser, std::min(coarser, 31.0)) << "no coarser than there is";
        all += coded.header + coded.bytes;
        return coded.begins_group;
    };
    EXPECT_TRUE(begins(0, 4, false));
    EXPECT_FALSE(begins(1, 3.5f, false)) << "within the room that was left";
    EXPECT_TRUE(begins(10, 3.5f, true));
    EXPECT_FALSE(begins(309, 3, false));
    EXPECT_TRUE(begins(311, 3, false)) << "after ten seconds";
    EXPECT_TRUE(begins(312, 2, false)) << "nearer than its range";
    EXPECT_FALSE(begins(313, 2, false, 18));
    EXPECT_FALSE(begins(314, 2, false, 100));
    all += encoder.finish();
    auto crf = coded_with(folder, all);
    EXPECT_EQ((crf[{TrackRole::main, 312}]), 20);
    EXPECT_EQ((crf[{TrackRole::main, 313}]), 38);
    EXPECT_EQ((crf[{TrackRole::depth, 313}]), 26) << "depth gives way after 12 steps";
    EXPECT_EQ((crf[{TrackRole::main, 314}]), 51);
    EXPECT_EQ((crf[{TrackRole::depth, 314}]), 39);
}

/// Two spheres with windows; the second is coded so much coarser.
std::string with_windows(const synthetic::Folder& folder, double coarser) {
    LiveEncoder encoder(quick());
    const WindowGrid grid{768, 384, 192, 96};
    std::string all;
    for (std::int64_t index = 0; index < 2; ++index) {
        FrameInfo of_window = synthetic::info(grid.width, grid.height, index);
        of_window.camera = window_camera(grid, {288, 144});
        const std::string window = rendered(folder / "window.exr", of_window, 4);
        const auto coded =
            encoder.encode(rendered(folder, index, 4), window, false, index > 0 ? coarser : 0, double(index) / 30);
        EXPECT_FALSE(std::filesystem::exists(window));
        all += coded.header + coded.bytes;
    }
    return all + encoder.finish();
}

/// A line that ends or becomes narrow between them has given the viewer what is all around it.
TEST(LiveEncoders, SendTheSphereBeforeItsWindow) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    std::ofstream(file, std::ios::binary) << with_windows(folder, 0);
    const StreamReader reader(file);
    AVFormatContext* opened = nullptr;
    ASSERT_GE(avformat_open_input(&opened, file.c_str(), nullptr, nullptr), 0);
    const av::Demuxer demuxer(opened);
    const av::Packet packet = av::make_packet();
    std::vector<TrackRole> order;
    for (; av_read_frame(demuxer.get(), packet.get()) >= 0; av_packet_unref(packet.get()))
        order.push_back(reader.tracks()[std::size_t(packet->stream_index)].role);
    ASSERT_GE(order.size(), 8u);
    for (const std::size_t sphere : {0u, 4u})
        EXPECT_EQ(std::vector(&order[sphere], &order[sphere] + 4),
                  (std::vector{TrackRole::main, TrackRole::depth, TrackRole::window, TrackRole::window_depth}));
}

TEST(LiveEncoders, TakeFromTheWindowFirstAndFromDepthLast) {
    const synthetic::Folder folder;
    auto crf = coded_with(folder, with_windows(folder, 18));
    EXPECT_EQ((crf[{TrackRole::window, 1}]), 38);
    EXPECT_EQ((crf[{TrackRole::main, 1}]), 26);
    EXPECT_EQ((crf[{TrackRole::window_depth, 1}]), 26);
    EXPECT_EQ((crf[{TrackRole::depth, 1}]), 20);
}

/// Also where it is coded coarser than the group before began.
TEST(LiveEncoders, EndWithAGroupForWhoHasLeftSomethingOut) {
    const synthetic::Folder folder;
    LiveEncoder encoder(quick());
    const std::string header = encoder.encode(rendered(folder, 0, 4), "", false, 0, 0).header;
    encoder.encode(rendered(folder, 1, 4), "", false, 18, 1 / 30.0);
    StreamReader reader("tcp://server:1", synthetic::as_sent(header + encoder.finish()));
    std::map<std::pair<TrackRole, std::int64_t>, float> crf;
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        crf[{picture.role, picture.info.value().index}] = picture.info->crf.value();
    EXPECT_EQ(crf, (std::map<std::pair<TrackRole, std::int64_t>, float>{{{TrackRole::main, 2}, 38.0f},
                                                                        {{TrackRole::depth, 2}, 26.0f}}));
    EXPECT_EQ(reader.truncation(), "");
}

TEST(LiveEncoders, BeginGroupsNoFasterHoweverManyCome) {
    const synthetic::Folder folder;
    LiveEncoder encoder(quick());
    std::vector<bool> begins;
    const auto encode = [&](std::int64_t index, bool asked, double now_s) {
        return encoder.encode(rendered(folder, index, 4), "", asked, 0, now_s).begins_group;
    };
    for (std::int64_t index = 0; index < 9; ++index)
        begins.push_back(encode(index, index < 3, double(index) / 30));
    EXPECT_EQ(begins, (std::vector<bool>{true, false, false, false, false, false, false, false, true}));
    EXPECT_TRUE(encode(9, true, 100)) << "after a time without viewers the first one need not wait";
}

}  // namespace
}  // namespace equistream::serve
