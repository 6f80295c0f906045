/// Turning a 3840x1920 sphere into a 1920x1080 view whose yaw changes each frame: the `rotation` engine on RGBA, on RGB
/// and on a decoder's planes, against FFmpeg's v360 (its map fixed, and rebuilt each frame as a moving head needs),
/// against OpenCV's remap (opencv.cpp) and against a copy of the view.
#include "agreement.h"
#include "eye_stages.h"

#include <client/warp/engine.h>

#include <benchmark/benchmark.h>

extern "C" {
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavutil/frame.h>
}

#include <cmath>
#include <cstring>
#include <string>

namespace {

using namespace equistream;

constexpr int source_width = bench::big_sphere.width, source_height = bench::big_sphere.height;
constexpr int view_width = bench::big_view.width, view_height = bench::big_view.height;

void ours(benchmark::State& state, const SourceView& source) {
    const auto engine = make_engine("sphere");
    engine->set_source(source);
    EyePicture picture;
    double yaw = 0;
    EyeView eye{.camera = bench::big_view, .pose = {}};
    for (auto _ : state) {
        yaw += 0.02;
        eye.pose.orientation = glm::angleAxis(yaw, glm::dvec3(0, 1, 0));
        engine->reproject(eye, picture);
        benchmark::DoNotOptimize(picture.rgba.samples().data());
    }
    state.SetLabel(bench::agreement_label("sphere", source, eye, picture));
}

void rgba(benchmark::State& state) {
    const ByteImage sphere = bench::big_picture(4);
    ours(state, {.rgb = sphere.view(), .camera = bench::big_sphere});
}

void rgb(benchmark::State& state) {
    const ByteImage sphere = bench::big_picture(3);
    ours(state, {.rgb = sphere.view(), .camera = bench::big_sphere});
}

void planes(benchmark::State& state) {
    const bench::BigPlanes sphere;
    ours(state, {.yuv = sphere.view(), .camera = bench::big_sphere});
}

/// A buffer -> v360 -> sink graph on 4:2:0 pictures, all cores.
class V360 {
public:
    V360() {
        const std::string source = "video_size=" + std::to_string(source_width) + "x" + std::to_string(source_height) +
                                   ":pix_fmt=yuv420p:time_base=1/30";
        const double v_fov = 2 * std::atan(static_cast<double>(view_height) / view_width) * 180 / pi;
        const std::string v360 = "e:flat:interp=linear:h_fov=90:v_fov=" + std::to_string(v_fov) +
                                 ":w=" + std::to_string(view_width) + ":h=" + std::to_string(view_height);
        graph_ = avfilter_graph_alloc();
        AVFilterContext* turn = nullptr;
        good_ = avfilter_graph_create_filter(&in_, avfilter_get_by_name("buffer"), "in", source.c_str(), nullptr,
                                             graph_) >= 0 &&
                avfilter_graph_create_filter(&turn, avfilter_get_by_name("v360"), "turn", v360.c_str(), nullptr,
                                             graph_) >= 0 &&
                avfilter_graph_create_filter(&out_, avfilter_get_by_name("buffersink"), "out", nullptr, nullptr,
                                             graph_) >= 0 &&
                avfilter_link(in_, 0, turn, 0) >= 0 && avfilter_link(turn, 0, out_, 0) >= 0 &&
                avfilter_graph_config(graph_, nullptr) >= 0;
        sphere_ = av_frame_alloc();
        sphere_->width = source_width;
        sphere_->height = source_height;
        sphere_->format = AV_PIX_FMT_YUV420P;
        av_frame_get_buffer(sphere_, 0);
        for (int plane = 0; plane < 3; ++plane)
            std::memset(sphere_->data[plane], 128,
                        static_cast<std::size_t>(sphere_->linesize[plane]) *
                            (plane ? source_height / 2 : source_height));
    }
    ~V360() {
        av_frame_free(&sphere_);
        avfilter_graph_free(&graph_);
    }
    V360(const V360&) = delete;
    V360& operator=(const V360&) = delete;

    bool good() const { return good_; }
    void set_yaw(double degrees) {
        avfilter_graph_send_command(graph_, "turn", "yaw", std::to_string(degrees).c_str(), nullptr, 0, 0);
    }
    void view() {
        sphere_->pts = next_pts_++;
        AVFrame* view = av_frame_alloc();
        good_ = good_ && av_buffersrc_add_frame_flags(in_, sphere_, AV_BUFFERSRC_FLAG_KEEP_REF) >= 0 &&
                av_buffersink_get_frame(out_, view) >= 0;
        av_frame_free(&view);
    }

private:
    AVFilterGraph* graph_ = nullptr;
    AVFilterContext* in_ = nullptr;
    AVFilterContext* out_ = nullptr;
    AVFrame* sphere_ = nullptr;
    std::int64_t next_pts_ = 0;
    bool good_ = false;
};

void v360(benchmark::State& state, bool turning) {
    V360 graph;
    if (!graph.good())
        return state.SkipWithError("v360 is not in this FFmpeg");
    graph.view();
    double yaw = 0;
    for (auto _ : state) {
        if (turning)
            graph.set_yaw(yaw = std::fmod(yaw + 1, 180));
        graph.view();
    }
    if (!graph.good())
        state.SkipWithError("v360 failed");
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, std::size_t{view_width} * view_height * 4);
}

BENCHMARK(rgba)->Name("rotate_1080p/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(rgb)->Name("rotate_rgb_1080p/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(planes)->Name("rotate_yuv_1080p/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(v360, fixed, false)->Name("rotate_1080p/v360_fixed")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(v360, turning, true)->Name("rotate_1080p/v360_turning")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("rotate_1080p/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
