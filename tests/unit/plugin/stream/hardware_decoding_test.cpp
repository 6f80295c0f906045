/// Decoding by hardware: where there is none, as on most machines that test, nobody notices that it was asked for.
#include "synthetic.h"

#include <plugin/stream/picture_decoding.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <utility>

namespace equistream {
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
            EXPECT_FALSE(found->decoder.empty());
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
