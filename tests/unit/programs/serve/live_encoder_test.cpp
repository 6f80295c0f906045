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

constexpr WindowGrid window_at_first{1536, 768, 384, 192};

/// The file of a window in the middle.
std::string window_of(const synthetic::Folder& folder, const WindowGrid& grid, std::int64_t index) {
    FrameInfo of_window = synthetic::info(grid.width, grid.height, index);
    of_window.camera = window_camera(grid, window_around(grid, {0, 0, -1}));
    return rendered(folder / "window.exr", of_window, 4);
}

/// Two spheres with windows; the second is coded so much coarser.
std::string with_windows(const synthetic::Folder& folder, double coarser) {
    LiveEncoder encoder(quick());
    std::string all;
    for (std::int64_t index = 0; index < 2; ++index) {
        const std::string window = window_of(folder, window_at_first, index);
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

/// By index, of a stream's pictures of the window and its depth.
using WindowSizes = std::map<std::int64_t, std::vector<std::pair<int, int>>>;
WindowSizes window_sizes(const std::string& stream) {
    StreamReader reader("tcp://server:1", synthetic::as_sent(stream));
    WindowSizes sizes;
    for (const DecodedPicture& picture : synthetic::read_all(reader)) {
        if (picture.role != TrackRole::window && picture.role != TrackRole::window_depth)
            continue;
        sizes[picture.info->index].emplace_back(picture.width, picture.height);
        EXPECT_EQ(width_of(picture.info->camera), picture.width);
        if (picture.role == TrackRole::window_depth)
            continue;
        const auto [least, most] = std::ranges::minmax(picture.rgb.samples());
        EXPECT_LE(most - least, 3) << "decoded with other parameter sets?";
    }
    return sizes;
}

/// A recording, each group from the one behind it: a decoder keeps the newest parameter sets.
void expect_the_same_backwards(const synthetic::Folder& folder, const std::string& stream) {
    std::ofstream(folder / "back.mkv", std::ios::binary) << stream;
    StreamReader reader((folder / "back.mkv").string());
    std::map<std::pair<TrackRole, std::int64_t>, int> widths;
    for (const DecodedPicture& picture : synthetic::read_all(reader))
        widths[{picture.role, picture.info->index}] = picture.width;
    for (const int first : {5, 4, 2, 0}) {
        ASSERT_TRUE(reader.seek(first / 30.0));
        const std::vector<DecodedPicture> pictures = synthetic::read_all(reader);
        EXPECT_GE(std::ssize(pictures), 4 * (7 - first)) << "four tracks of seven pictures";
        for (const DecodedPicture& picture : pictures)
            EXPECT_EQ((widths[{picture.role, picture.info->index}]), picture.width);
        EXPECT_EQ(reader.truncation(), "") << "from " << first;
    }
}

/// Whoever has been there from the start, and whoever comes by the header of the first size.
TEST(LiveEncoders, FollowAWindowToAnotherSize) {
    const synthetic::Folder folder;
    LiveEncoder encoder(quick());
    const WindowGrid halved = halved_window_grid(window_at_first, 1),
                     quartered = halved_window_grid(window_at_first, 2);
    std::string header;
    std::map<std::int64_t, std::string> since;  // by the index of the first
    WindowSizes expected;
    const auto encode = [&](std::int64_t index, const WindowGrid& grid, double coarser) {
        const auto coded = encoder.encode(rendered(folder, index, 4), window_of(folder, grid, index), false, coarser,
                                          double(index) / 30);
        header += coded.header;
        since[index];
        for (auto& [first, bytes] : since)
            bytes += coded.bytes;
        expected[index] = {{grid.width, grid.height}, {grid.width, grid.height}};
        return coded;
    };
    encode(0, window_at_first, 0);
    EXPECT_FALSE(encode(1, window_at_first, 16).begins_group);
    const auto smaller = encode(2, quartered, 16);
    EXPECT_TRUE(smaller.begins_group) << "sooner than others may";
    EXPECT_NEAR(smaller.window_halvings, 2, 1e-9);
    EXPECT_EQ(smaller.coarser, 16);
    EXPECT_FALSE(encode(3, quartered, 0).begins_group);
    EXPECT_TRUE(encode(4, halved, 0).begins_group);
    EXPECT_TRUE(encode(5, window_at_first, 0).begins_group);
    EXPECT_FALSE(encode(6, window_at_first, 0).begins_group);
    const std::string end = encoder.finish();
    EXPECT_EQ(window_sizes(header + since[0]), expected);
    for (const std::int64_t first : {2, 4, 5}) {
        SCOPED_TRACE(first);
        expected.erase(expected.begin(), expected.find(first));
        EXPECT_EQ(window_sizes(header + since[first]), expected);
    }
    expect_the_same_backwards(folder, header + since[0] + end);
    auto crf = coded_with(folder, header + since[0] + end);
    EXPECT_EQ((crf[{TrackRole::window, 1}]), 36);
    EXPECT_EQ((crf[{TrackRole::window, 2}]), 24) << "12 steps have gone into its pixels";
    EXPECT_EQ((crf[{TrackRole::main, 2}]), 24);
    EXPECT_EQ((crf[{TrackRole::window, 3}]), 20) << "no finer than asked for";
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
