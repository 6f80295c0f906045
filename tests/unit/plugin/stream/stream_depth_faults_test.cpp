/// Depth tracks that are cut, lie or cannot be coded.
#include "depth_stream.h"

#include <client/receive/receive.h>
#include <equistream/error.h>

#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <limits>
#include <string_view>

namespace equistream::test {
namespace {

/// Changes the frame data of every picture of a file that starts with `role`.
void edit_frame_data(const std::string& file, TrackRole role, const std::function<void(char*, std::size_t)>& edit) {
    std::string bytes = bytes_of(file);
    const auto payload = encode_frame_info(role, {});
    const std::string start(payload.begin(), payload.begin() + 18);
    int edited = 0;
    for (std::size_t at = bytes.find(start); at != bytes.npos; at = bytes.find(start, at + 1))
        if (bytes[at + 20] == char(role)) {
            edit(bytes.data() + at, bytes.size() - at);
            ++edited;
        }
    ASSERT_GT(edited, 0);
    std::ofstream(file, std::ios::binary) << bytes;
}

TEST(DepthStreams, PicturesWhoseDataLieAreLeftOut) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.nut";
    // A depth track that says it is colour; colour that says it is depth; another code's samples.
    for (const auto& [role, claimed_role, claimed_code] :
         {std::tuple{TrackRole::depth, TrackRole::hidden, -1},
          {TrackRole::main, TrackRole::depth, -1},
          {TrackRole::depth, TrackRole::depth, int(DepthCodeId::pece444)},
          {TrackRole::depth, TrackRole::depth, int(DepthCodeId::w12)}}) {
        write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
        std::string radius(sizeof(double), ' ');  // two bytes behind the code
        std::memcpy(radius.data(), &range.box_radius_m, sizeof(double));
        edit_frame_data(file, role, [&, c_role = claimed_role, code = claimed_code](char* payload, std::size_t left) {
            payload[20] = char(c_role);
            const std::size_t at = std::string_view(payload, std::min<std::size_t>(left, 600)).find(radius);
            if (code >= 0 && at != std::string_view::npos)
                payload[at - 2] = char(code);
        });
        StreamReader reader(file);
        while (const auto picture = reader.next())
            EXPECT_NE(picture->role, claimed_role == TrackRole::hidden ? TrackRole::hidden : TrackRole::patches);
        EXPECT_NE(reader.truncation(), "");
        EXPECT_EQ(reader.truncation().find('\n'), std::string::npos);
    }
}

TEST(DepthStreams, EveryCutPlaysUpToItOrIsToldInOneLine) {
    const synthetic::Folder folder;
    const std::string whole = folder / "a.mkv", cut = folder / "cut.mkv";
    write(whole, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
    const std::string bytes = bytes_of(whole);
    for (int part = 1; part < 16; ++part) {
        std::ofstream(cut, std::ios::binary) << bytes.substr(0, bytes.size() * std::size_t(part) / 16);
        try {
            const auto feed = open_feed(cut, {.depth = true});
            while (const auto frame = feed->next())
                EXPECT_GE(frame->main.info.index, 0);
            EXPECT_NE(feed->truncation(), "") << part;
            EXPECT_EQ(feed->truncation().find('\n'), std::string::npos);
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        }
    }
}

TEST(DepthStreams, WritersRefuseWhatCannotBeCoded) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    StreamSettings settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[1].depth_code.reset();
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[0].depth_code = DepthCodeId::w10;
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = settings_of(Codec::h264, DepthCodeId::w10);
    settings.tracks[1].crf = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    settings = halved_settings(DepthCodeId::w10, 16);
    settings.tracks[0].halved = true;  // colour
    EXPECT_THROW(StreamWriter(file, settings), InputError);
    for (const auto& [w, h] : {std::pair{width + 2, height}, {width, 2 * min_track_side - 4}}) {
        settings = halved_settings(DepthCodeId::w10, 16);
        settings.tracks[1].width = w;
        settings.tracks[1].height = h;
        EXPECT_THROW(StreamWriter(file, settings), InputError) << w << "x" << h;
    }

    StreamWriter writer(file, settings_of(Codec::h264, DepthCodeId::w10));
    const FloatImage depth_m = depth_of(0);
    EXPECT_THROW(writer.write_depth(TrackRole::depth, depth_m.view(), info_of(0)), WorkError);
    EXPECT_THROW(writer.write_depth(TrackRole::depth, depth_m.view(), info_of(1, DepthCodeId::w8)), WorkError);
    EXPECT_THROW(writer.write_depth(TrackRole::main, depth_m.view(), info_of(2, DepthCodeId::w10)), WorkError);
    EXPECT_THROW(writer.write(TrackRole::depth, synthetic::picture(width, height, 3).view(), info_of(3)), WorkError);
    // No reader would take it.
    EXPECT_THROW(
        writer.write(TrackRole::main, synthetic::picture(width, height, 4).view(), info_of(4, DepthCodeId::w10)),
        WorkError);
}

}  // namespace
}  // namespace equistream::test
