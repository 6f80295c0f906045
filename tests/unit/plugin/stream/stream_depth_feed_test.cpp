/// Depth tracks as a client's feed gives them, with the colour they belong to.
#include "depth_stream.h"

#include <client/receive/receive.h>
#include <equistream/depth_code.h>

#include <gtest/gtest.h>

#include <algorithm>
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
}  // namespace equistream::test
