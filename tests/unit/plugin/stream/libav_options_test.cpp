#include "synthetic.h"

#include <equistream/error.h>

#include <plugin/stream/libav.h>
#include <plugin/stream/picture_decoding.h>
#include <plugin/stream/track_encoder.h>

#include <gtest/gtest.h>
extern "C" {
#include <libavutil/hwcontext.h>
}
#include <malloc.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>
#include <vector>

namespace equistream::av {
namespace {

Muxer null_muxer() {
    AVFormatContext* opened = nullptr;
    EXPECT_GE(avformat_alloc_output_context2(&opened, nullptr, "null", nullptr), 0);
    Muxer muxer(opened);
    AVCodecParameters& video = *avformat_new_stream(muxer.get(), nullptr)->codecpar;
    video.codec_type = AVMEDIA_TYPE_VIDEO;
    video.codec_id = AV_CODEC_ID_RAWVIDEO;
    video.width = video.height = 16;
    return muxer;
}

/// In processes of their own, for it is done once.
TEST(LibavLogDeathTest, IsSilencedUnlessTheHostChoseItsLevel) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto silence = [](int level) {
        av_log_set_level(level);
        silence_log();
        return av_log_get_level();
    };
    EXPECT_EXIT(std::exit(silence(AV_LOG_INFO) == AV_LOG_QUIET ? 0 : 1), testing::ExitedWithCode(0), "");
    EXPECT_EXIT(std::exit(silence(AV_LOG_ERROR) == AV_LOG_ERROR ? 0 : 1), testing::ExitedWithCode(0), "");
}

TEST(LibavOptions, OnesThatWereTakenAreNoError) {
    const Muxer muxer = null_muxer();
    Options options;
    options.set("avoid_negative_ts", "disabled");
    ASSERT_GE(avformat_init_output(muxer.get(), options.taken()), 0);
    EXPECT_NO_THROW(options.require_all_taken("the container null"));
}

TEST(LibavOptions, OneThatNobodyTookIsNamed) {
    const Muxer muxer = null_muxer();
    Options options;
    options.set("avoid_negative_ts", "disabled");
    options.set("no_such_option", "1");
    ASSERT_GE(avformat_init_output(muxer.get(), options.taken()), 0);
    try {
        options.require_all_taken("the container null");
        FAIL() << "an option that nobody knows went unnoticed";
    } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "the container null does not know the option no_such_option");
    }
}

/// An enum may not even be assigned a number that it has no name for.
void set(auto& value, int number) {
    static_assert(sizeof value == sizeof number);
    std::memcpy(&value, &number, sizeof number);
}

template <typename Tagged>
void expect_unknown_colours_forgotten(Tagged tagged, AVColorSpace Tagged::*space) {
    tagged.color_range = AVCOL_RANGE_JPEG;
    tagged.color_primaries = AVCOL_PRI_BT2020;
    tagged.color_trc = AVCOL_TRC_SMPTE2084;
    tagged.*space = AVCOL_SPC_BT2020_NCL;
    tagged.chroma_location = AVCHROMA_LOC_TOPLEFT;
    forget_unknown_colours(tagged);
    EXPECT_EQ(tagged.color_range, AVCOL_RANGE_JPEG);
    EXPECT_EQ(tagged.color_primaries, AVCOL_PRI_BT2020);
    EXPECT_EQ(tagged.color_trc, AVCOL_TRC_SMPTE2084);
    EXPECT_EQ(tagged.*space, AVCOL_SPC_BT2020_NCL);
    EXPECT_EQ(tagged.chroma_location, AVCHROMA_LOC_TOPLEFT);
    for (const int number : {-1, 4321}) {
        set(tagged.color_range, number);
        set(tagged.color_primaries, number);
        set(tagged.color_trc, number);
        set(tagged.*space, number);
        set(tagged.chroma_location, number);
        forget_unknown_colours(tagged);
        EXPECT_EQ(tagged.color_range, AVCOL_RANGE_UNSPECIFIED);
        EXPECT_EQ(tagged.color_primaries, AVCOL_PRI_UNSPECIFIED);
        EXPECT_EQ(tagged.color_trc, AVCOL_TRC_UNSPECIFIED);
        EXPECT_EQ(tagged.*space, AVCOL_SPC_UNSPECIFIED);
        EXPECT_EQ(tagged.chroma_location, AVCHROMA_LOC_UNSPECIFIED);
    }
}

TEST(LibavColours, WithoutANameAreForgottenAndOthersStay) {
    expect_unknown_colours_forgotten(AVCodecParameters{}, &AVCodecParameters::color_space);
    expect_unknown_colours_forgotten(AVFrame{}, &AVFrame::colorspace);
}

}  // namespace
}  // namespace equistream::av

namespace equistream {
namespace {

/// What an allocation finds is what was there before, so that a value nobody set shows in one run of many: here it
/// shows in each.
class FilledAllocations {
public:
    FilledAllocations() { mallopt(M_PERTURB, 0x5a); }
    ~FilledAllocations() { mallopt(M_PERTURB, 0); }
};

struct Times {
    std::int64_t pts = 0, dts = 0;
};

std::vector<Times> times_of(Codec codec, int pictures) {
    av::silence_log();
    const FilledAllocations filled;
    StreamSettings settings;
    settings.codec = codec;
    settings.tracks = {{.width = 64, .height = 64}};
    TrackEncoder encoder(settings, settings.tracks.front(), true);
    std::vector<Times> times;
    const auto take = [&](AVPacket& packet) { times.push_back({packet.pts, packet.dts}); };
    const ByteImage rgb(64, 64, 3, 90);
    const std::vector<std::uint8_t> payload(32, 1);
    for (int i = 0; i < pictures; ++i)
        encoder.encode(encoder.convert(rgb.view()), i, payload, take);
    encoder.drain(take);
    return times;
}

TEST(TrackEncoder, ShortTracksAreDecodedWhenTheirPicturesAre) {
    for (const Codec codec : {Codec::h264, Codec::h265})
        for (const int pictures : {1, 2, 3, 4, 40}) {
            const std::vector<Times> times = times_of(codec, pictures);
            ASSERT_EQ(int(times.size()), pictures);
            for (std::size_t i = 0; i < times.size(); ++i) {
                EXPECT_LE(times[i].dts, times[i].pts) << pictures << " pictures";
                // No earlier than by as many pictures as the decoder is told to put in order.
                EXPECT_GE(times[i].dts, std::int64_t(i) - 2) << pictures << " pictures";
                EXPECT_TRUE(i == 0 || times[i].dts > times[i - 1].dts) << pictures << " pictures";
            }
        }
}

}  // namespace

// Decoding by hardware: where there is none, as on most machines that test, nobody notices that it was asked for.

namespace {

av::Frame nv12(int width, int height) {
    av::Frame frame = av::make_frame();
    frame->format = AV_PIX_FMT_NV12;
    frame->width = width;
    frame->height = height;
    frame->pts = 17;
    EXPECT_EQ(av_frame_get_buffer(frame.get(), 0), 0);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            frame->data[0][y * frame->linesize[0] + x] = std::uint8_t(10 * y + x);
    for (int y = 0; y < (height + 1) / 2; ++y)
        for (int x = 0; x < (width + 1) / 2; ++x) {
            frame->data[1][y * frame->linesize[1] + 2 * x] = std::uint8_t(100 + 10 * y + x);
            frame->data[1][y * frame->linesize[1] + 2 * x + 1] = std::uint8_t(200 + 10 * y + x);
        }
    return frame;
}

TEST(HardwareDecoding, AlternatingChromaGetsPlanesOfItsOwn) {
    for (const auto& [width, height] : {std::pair{8, 4}, {6, 6}, {7, 5}}) {
        const av::Frame planar = with_own_chroma_planes(nv12(width, height));
        ASSERT_NE(planar, nullptr);
        EXPECT_EQ(planar->format, AV_PIX_FMT_YUV420P);
        EXPECT_EQ(planar->pts, 17) << "what came with it stays";
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                EXPECT_EQ(planar->data[0][y * planar->linesize[0] + x], 10 * y + x);
                EXPECT_EQ(planar->data[1][y / 2 * planar->linesize[1] + x / 2], 100 + 10 * (y / 2) + x / 2);
                EXPECT_EQ(planar->data[2][y / 2 * planar->linesize[2] + x / 2], 200 + 10 * (y / 2) + x / 2);
            }
    }
}

TEST(HardwareDecoding, OtherPicturesStay) {
    av::Frame frame = nv12(8, 4);
    frame->format = AV_PIX_FMT_GRAY8;
    const AVFrame* before = frame.get();
    EXPECT_EQ(with_own_chroma_planes(std::move(frame)).get(), before);
}

TEST(HardwareDecoding, GivesTheSamePicturesOrLeavesThemToSoftware) {
    const synthetic::Folder folder;
    for (const Codec codec : {Codec::h264, Codec::h265}) {
        synthetic::Made made = synthetic::small_stream(codec, true);
        const auto file = folder / "a.mkv";
        synthetic::write(file, made);
        StreamReader software(file.string(), {.yuv = true}), asked(file.string(), {.yuv = true, .hardware = true});
        while (const auto expected = software.next()) {
            const auto found = asked.next();
            ASSERT_TRUE(found);
            EXPECT_EQ(expected->decoder, "software");
            const std::string by(found->decoder);
            EXPECT_TRUE(by == "software" || av_hwdevice_find_type_by_name(by.c_str()) != AV_HWDEVICE_TYPE_NONE) << by;
            ASSERT_FALSE(found->yuv.empty());
            EXPECT_EQ(found->info->index, expected->info->index);
            for (const auto plane : {&YuvView::y, &YuvView::cb, &YuvView::cr})
                for (int y = 0; y < (expected->yuv.planes.*plane).height; ++y)
                    EXPECT_TRUE(
                        std::equal((expected->yuv.planes.*plane).pixel(0, y),
                                   (expected->yuv.planes.*plane).pixel(0, y) + (expected->yuv.planes.*plane).width,
                                   (found->yuv.planes.*plane).pixel(0, y)));
        }
        EXPECT_FALSE(asked.next());
    }
}

}  // namespace
}  // namespace equistream
