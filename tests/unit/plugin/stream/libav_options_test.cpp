#include <plugin/stream/libav.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace equistream::av
