/// Reading a stream of 24 pictures of 1280x640 (H.264, CRF 16) to its end: our reader, which finds the poses, checks
/// every picture and holds one back, against libavformat and libavcodec alone; and both with the way to RGB, there by
/// libswscale. All use every core.
#include "bench_scene.h"

#include <equistream/error.h>
#include <plugin/stream/libav.h>

#include <benchmark/benchmark.h>

extern "C" {
#include <libavutil/opt.h>
}

#include <cmath>

namespace {

using namespace equistream;

constexpr int width = 1280, height = 640, picture_count = 24;

/// Waves that move, and the grain of a path traced picture.
ByteImage picture(int index) {
    ByteImage rgb(width, height, 3);
    std::uint32_t state = static_cast<std::uint32_t>(index) + 1;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                state = state * 1664525u + 1013904223u;
                const double wave = std::sin(0.02 * (c + 1) * x + 0.1 * index) * std::cos(0.03 * y);
                rgb.pixel(x, y)[c] = static_cast<std::uint8_t>(128 + 90 * wave + (state >> 28));
            }
    return rgb;
}

const bench::CodedSphere& coded() {
    static const bench::CodedSphere coded({width, height, {}}, picture_count, "fast", picture);
    return coded;
}

void expect_all(benchmark::State& state, int pictures) {
    if (pictures != picture_count)
        state.SkipWithError("not every picture was read");
}

void ours(benchmark::State& state, bool rgb) {
    const std::string file = coded().name();
    for (auto _ : state) {
        StreamReader reader(file, {.rgb = rgb});
        int pictures = 0;
        while (const auto next = reader.next())
            ++pictures;
        expect_all(state, pictures);
    }
}

av::Scaler scaler_to_rgb() {
    av::Scaler scaler(sws_alloc_context());
    for (const char* option : {"srcw", "dstw"})
        av_opt_set_int(scaler.get(), option, width, 0);
    for (const char* option : {"srch", "dsth"})
        av_opt_set_int(scaler.get(), option, height, 0);
    av_opt_set_int(scaler.get(), "src_format", AV_PIX_FMT_YUV420P, 0);
    av_opt_set_int(scaler.get(), "dst_format", AV_PIX_FMT_RGB24, 0);
    av_opt_set_int(scaler.get(), "sws_flags", SWS_BILINEAR, 0);
    av_opt_set_int(scaler.get(), "threads", 0, 0);
    return sws_init_context(scaler.get(), nullptr, nullptr) < 0 ? nullptr : std::move(scaler);
}

/// What a player does and no more.
class PlainReader {
public:
    PlainReader(const std::string& file, bool rgb) {
        AVFormatContext* opened = nullptr;
        if (avformat_open_input(&opened, file.c_str(), nullptr, nullptr) < 0)
            throw WorkError("libavformat cannot open the stream");
        format_.reset(opened);
        avformat_find_stream_info(format_.get(), nullptr);
        const AVCodecParameters& parameters = *format_->streams[0]->codecpar;
        const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
        codec_.reset(avcodec_alloc_context3(decoder));
        avcodec_parameters_to_context(codec_.get(), &parameters);
        codec_->thread_count = 0;
        avcodec_open2(codec_.get(), decoder, nullptr);
        if (rgb)
            scaler_ = scaler_to_rgb();
    }

    int read_all() {
        const av::Packet packet = av::make_packet();
        int pictures = 0;
        while (av_read_frame(format_.get(), packet.get()) >= 0) {
            avcodec_send_packet(codec_.get(), packet.get());
            av_packet_unref(packet.get());
            pictures += receive();
        }
        avcodec_send_packet(codec_.get(), nullptr);
        return pictures + receive();
    }

private:
    int receive() {
        int pictures = 0;
        for (; avcodec_receive_frame(codec_.get(), frame_.get()) >= 0; ++pictures)
            if (scaler_) {
                const av::Frame rgb = av::make_frame();
                sws_scale_frame(scaler_.get(), rgb.get(), frame_.get());
                benchmark::DoNotOptimize(rgb->data[0]);
            }
        return pictures;
    }

    av::Demuxer format_;
    av::Codec codec_;
    av::Scaler scaler_;
    av::Frame frame_ = av::make_frame();
};

void plain(benchmark::State& state, bool rgb) {
    const std::string file = coded().name();
    for (auto _ : state)
        expect_all(state, PlainReader(file, rgb).read_all());
}

BENCHMARK_CAPTURE(ours, yuv, false)->Name("decode_1280x640/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, yuv, false)->Name("decode_1280x640/libavcodec")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, rgb, true)->Name("decode_rgb_1280x640/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(plain, rgb, true)
    ->Name("decode_rgb_1280x640/libavcodec_libswscale")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
