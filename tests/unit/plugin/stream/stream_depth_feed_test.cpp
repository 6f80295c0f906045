/// Depth tracks as a client's feed gives them, with the colour they belong to.
#include "depth_stream.h"

#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <client/receive/receive.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <limits>
#include <string_view>
#include <vector>

namespace equistream::test {
namespace {

TEST(DepthStreams, AFeedGivesDepthWithItsColourOrLeavesItOut) {
    const synthetic::Folder folder;
    for (const char* name : {"a.mkv", "a.ts"}) {  // with names of tracks and without
        const std::string file = folder / name;
        write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
        for (const bool depth : {true, false}) {
            const auto feed = open_feed(file, {.depth = depth});
            int frames = 0;
            while (const auto frame = feed->next()) {
                EXPECT_EQ(frame->main.depth_m.empty(), !depth);
                EXPECT_EQ(frame->main.info.depth_code.has_value(), depth);
                EXPECT_FALSE(frame->small);
                ++frames;
            }
            EXPECT_EQ(frames, pictures);
            EXPECT_EQ(feed->truncation(), "");
            std::int64_t depth_pictures = -1;
            for (const FeedTrack& track : feed->tracks())
                if (track.name == "depth")
                    depth_pictures = track.pictures;
            EXPECT_EQ(depth_pictures, depth ? pictures : 0) << name;
        }
    }
}

TEST(DepthStreams, AFeedGivesTheDecodersOwnPlanes) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    write(file, settings_of(Codec::h264, DepthCodeId::w10), DepthCodeId::w10);
    const auto as_rgb = open_feed(file), as_yuv = open_feed(file, {.yuv = true});
    std::vector<ReceivedFrame> kept;  // planes outlive the decoder's next pictures
    while (auto frame = as_yuv->next())
        kept.push_back(std::move(*frame));
    ASSERT_EQ(kept.size(), std::size_t(pictures));
    for (const ReceivedFrame& frame : kept) {
        const auto rgb = as_rgb->next();
        ASSERT_TRUE(rgb && rgb->main.yuv.empty() && frame.main.rgb.empty() && !frame.main.yuv.empty());
        EXPECT_EQ(frame.main.width(), width);
        EXPECT_EQ(frame.main.height(), height);
        const YuvView& planes = frame.main.yuv.planes;
        EXPECT_EQ(planes.cb.width, width / 2);
        // Luma of the RGB that was made of it, within what rounding and clipping leave.
        double sum = 0;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint8_t* c = rgb->main.rgb.pixel(x, y);
                const double luma = 16 + bt709::luma_scale * (bt709::kr * c[0] + bt709::kg * c[1] + bt709::kb * c[2]);
                sum += std::abs(luma - planes.y.row(y)[x]);
            }
        EXPECT_LT(sum / (width * height), 1.0);
    }
}

TEST(DepthStreams, ALostDepthPictureLeavesItsColour) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.nut";
    StreamSettings settings = settings_of(Codec::h264, DepthCodeId::w8);
    StreamWriter writer(file, settings);
    for (std::int64_t index = 0; index < pictures; ++index) {
        writer.write(TrackRole::main, synthetic::picture(width, height, index).view(), info_of(index));
        if (index != 3)
            writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, DepthCodeId::w8));
    }
    writer.finish();
    const auto feed = open_feed(file, {.depth = true});
    std::int64_t frames = 0;
    for (; const auto frame = feed->next(); ++frames)
        EXPECT_EQ(frame->main.depth_m.empty(), frames == 3);
    EXPECT_EQ(frames, pictures);
}

/// Colour that goes with depth_of(), so that it tells the ball from what is behind.
ByteImage colour_of(std::int64_t index) {
    ByteImage rgb(width, height, 3, 60);
    const FloatImage depth_m = depth_of(index);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            if (*depth_m.pixel(x, y) == 0.75f)
                std::fill_n(rgb.pixel(x, y), 3, std::uint8_t{200});
    return rgb;
}

TEST(DepthStreams, AFeedTellsHalvedDepthApartByItsColour) {
    const synthetic::Folder folder;
    const std::string file = folder / "a.mkv";
    {
        StreamSettings settings = halved_settings(DepthCodeId::lossless, 16);
        settings.crf = 8;
        StreamWriter writer(file, settings);
        for (std::int64_t index = 0; index < pictures; ++index) {
            writer.write(TrackRole::main, colour_of(index).view(), info_of(index));
            writer.write_depth(TrackRole::depth, depth_of(index).view(), info_of(index, DepthCodeId::lossless));
        }
        writer.finish();
    }
    for (const bool yuv : {false, true}) {
        const auto feed = open_feed(file, {.depth = true, .yuv = yuv});
        std::int64_t wrong = 0, wrong_without = 0, index = 0;
        for (; const auto frame = feed->next(); ++index) {
            const FloatImage sent = depth_of(index), repeated = double_depth(halve_depth(sent.view()).view());
            ASSERT_EQ(frame->main.depth_m.samples().size(), sent.samples().size());
            const auto is_ball = [](float r) { return r == 0.75f; };
            for (std::size_t i = 0; i < sent.samples().size(); ++i) {
                wrong += is_ball(frame->main.depth_m.samples()[i]) != is_ball(sent.samples()[i]);
                wrong_without += is_ball(repeated.samples()[i]) != is_ball(sent.samples()[i]);
            }
        }
        EXPECT_EQ(index, pictures);
        EXPECT_GT(wrong_without, 40 * pictures);
        EXPECT_LT(wrong * 5, wrong_without);
    }
}

}  // namespace

// Depth tracks that are cut, lie or cannot be coded.

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
