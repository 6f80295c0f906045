#include "synthetic.h"

#include <gtest/gtest.h>

#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace equistream {
namespace {

/// Made while others watch: bytes of each picture at once, groups and qualities as asked for.
TEST(Stream, LivePicturesComeAtOnceAndSayTheirQuality) {
    const synthetic::Folder folder;
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    settings.live = true;
    std::string bytes;
    const auto take = [&](std::span<const std::uint8_t> more) { bytes.append(more.begin(), more.end()); };
    StreamWriter writer("live.mkv", settings, StreamTap{take});
    const std::string header = bytes;
    std::size_t second_group = 0;
    for (const std::int64_t index : {0, 1, 2, 3, 4, 5}) {
        if (index == 3) {
            second_group = bytes.size();
            writer.begin_group();
            writer.set_crf(TrackRole::main, 40);
        }
        const std::size_t before = bytes.size();
        writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), synthetic::info(192, 96, index));
        writer.flush();
        EXPECT_GT(bytes.size(), before) << index;
    }
    writer.finish();
    std::ofstream(folder / "a.mkv", std::ios::binary) << bytes;

    StreamReader reader((folder / "a.mkv").string());
    const std::vector<DecodedPicture> pictures = synthetic::read_all(reader);
    EXPECT_EQ(reader.truncation(), "");
    ASSERT_EQ(pictures.size(), 7u);  // the last one again, which says so
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const FrameInfo& said = pictures[i].info.value();
        EXPECT_EQ(said.index, std::int64_t(i));
        EXPECT_EQ(said.crf, i < 3 ? 16.0f : 40.0f);
        EXPECT_NEAR(said.time_s, double(i) / 30, 1e-12);
        EXPECT_NEAR(pictures[i].time_s.value(), double(i) / 30, 2e-3);
    }
    EXPECT_GT(pictures[3].bytes, pictures[4].bytes);
    EXPECT_NEAR(reader.newest_s(0).value(), 6 / 30.0, 2e-3);
    EXPECT_GT(synthetic::psnr_db(pictures[6].rgb, pictures[5].rgb), 30);
    std::ofstream(folder / "b.mkv", std::ios::binary) << header << bytes.substr(second_group);
    StreamReader joined((folder / "b.mkv").string());
    EXPECT_EQ(joined.next().value().info.value().index, 3) << "a group begins there, which is all that a viewer needs";
}

/// Whoever has left out what lies before gets the end too.
TEST(Stream, TheEndOfALiveStreamBeginsAGroupWhereOneIsAskedFor) {
    StreamSettings settings;
    settings.preset = "ultrafast";
    settings.tracks = {{TrackRole::main, 192, 96}};
    settings.live = true;
    std::string bytes;
    StreamWriter writer("live.mkv", settings,
                        StreamTap{[&](std::span<const std::uint8_t> more) { bytes.append(more.begin(), more.end()); }});
    const std::string header = bytes;
    for (const std::int64_t index : {0, 1, 2}) {
        writer.write(TrackRole::main, synthetic::picture(192, 96, index).view(), synthetic::info(192, 96, index));
        writer.flush();
    }
    const std::size_t end = bytes.size();
    writer.begin_group();
    writer.finish();
    StreamReader reader("tcp://server:1", synthetic::as_sent(header + bytes.substr(end)));
    const std::vector<DecodedPicture> pictures = synthetic::read_all(reader);
    ASSERT_EQ(pictures.size(), 1u);
    EXPECT_EQ(pictures.front().info.value().index, 3);
    EXPECT_GT(synthetic::psnr_db(pictures.front().rgb, synthetic::picture(192, 96, 2)), 30);
    EXPECT_EQ(reader.truncation(), "");
}

}  // namespace
}  // namespace equistream
