/// A stream of 3840x1920 pictures (H.264, CRF 16) played to two 1920x1080 eyes: decoding, the `eye-depth` engine on the
/// decoder's own planes and the filling of gaps, all depths given, against decoding alone. Read ahead and with the eyes
/// side by side, as `equistream play` does. Both use every core, and the clock runs from opening the file to the last
/// picture: libav decodes on threads of its own while eyes are filled, so that the ratio is that of all work done.
#include "bench_scene.h"
#include "eye_stages.h"

#include <client/fill/fill.h>
#include <client/receive/receive.h>
#include <client/warp/engine.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <optional>

namespace {

using namespace equistream;

constexpr int picture_count = 16;

/// Waves that move, and the grain of a path traced picture.
ByteImage picture(int index) {
    ByteImage rgb(bench::big_sphere.width, bench::big_sphere.height, 3);
    std::uint32_t state = static_cast<std::uint32_t>(index) + 1;
    for (int y = 0; y < rgb.height(); ++y) {
        const double down = std::cos(0.011 * y);
        for (int x = 0; x < rgb.width(); ++x) {
            const double wave = std::sin(0.013 * x + 0.1 * index) * down;
            for (int c = 0; c < 3; ++c) {
                state = state * 1664525u + 1013904223u;
                rgb.pixel(x, y)[c] = static_cast<std::uint8_t>(128 + (60 + 15 * c) * wave + (state >> 29));
            }
        }
    }
    return rgb;
}

/// The stage's eyes, of whatever is decoded.
class Eyes {
public:
    void see(const YuvView& planes) {
        source_.yuv = planes;
        engine_->set_source(source_);
        FillInputs inputs;
        inputs.main = &source_;
        for (const auto& fill_pass : chain_)
            fill_pass->set_frame(inputs);
        tbb::parallel_for(0, 2, [&](int i) {
            engine_->reproject(stage_.eye(std::size_t(i)), pictures_[i]);
            fill_gaps(chain_, stage_.eye(std::size_t(i)), pictures_[i]);
        });
        benchmark::DoNotOptimize(pictures_[1].rgba.samples().data());
    }

private:
    std::unique_ptr<Engine> engine_ = make_engine("surface");
    FillChain chain_ = make_fill_chain("pushpull");
    bench::TwoEyesStage stage_{*bench::bench_scene("pavilion")};
    SourceView source_ = stage_.source_of_depth();
    EyePicture pictures_[2];
};

const bench::CodedSphere& coded() {
    static const bench::CodedSphere only(bench::big_sphere, picture_count, "veryfast", picture);
    return only;
}

void require_all(benchmark::State& state, int pictures) {
    if (pictures != picture_count)
        state.SkipWithError("not every picture was read");
}

void two_eyes(benchmark::State& state) {
    static Eyes both;
    for (auto _ : state) {
        const auto feed = open_feed(coded().name(), {.yuv = true, .frames_ahead = 1});
        int pictures = 0;
        for (; const auto frame = feed->next(); ++pictures)
            both.see(frame->main.yuv.planes);
        require_all(state, pictures);
    }
}

void decoding(benchmark::State& state) {
    for (auto _ : state) {
        StreamReader reader(coded().name(), {.yuv = true});
        int pictures = 0;
        for (; const auto picture = reader.next(); ++pictures)
            benchmark::DoNotOptimize(picture->yuv.planes.y.data);
        require_all(state, pictures);
    }
}

BENCHMARK(two_eyes)->Name("play_3840x1920/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(decoding)->Name("play_3840x1920/decoding_alone")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
