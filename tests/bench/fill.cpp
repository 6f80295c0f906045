/// The gaps of two 1920x1080 eyes beside a 3840x1920 sphere of the bundled scene, its colours a function of the place:
/// `pushpull`, the fill pass that is always there, on all cores, against OpenCV's inpainting (Telea 2004, radius 3; it
/// uses one core) of the same gaps, one eye after the other; with the PSNR of the filled pixels to what the eyes truly
/// see.
#include "bench_scene.h"

#include <client/fill/fill.h>
#include <client/warp/engine.h>
#include <equistream/bound.h>

#include <benchmark/benchmark.h>
#ifdef EQUISTREAM_WITH_OPENCV
#include <opencv2/photo.hpp>
#endif

#include <tbb/parallel_for.h>

#include <cstdio>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{3840, 1920, {}};
constexpr PerspectiveCamera view{1920, 1080, pi / 2};
constexpr double head_radius_m = 0.048;  ///< sideways: gaps of just under four per cent

/// Coarse and fine detail, so that a wrong surface shows and a blurred one too.
glm::vec3 colour_of(const glm::dvec3& p) {
    const glm::dvec3 coarse = glm::sin(2.1 * p + glm::dvec3(0, 1, 2)) * glm::cos(1.3 * glm::dvec3(p.y, p.z, p.x));
    const glm::dvec3 fine = glm::sin(23.0 * p) * glm::cos(17.0 * glm::dvec3(p.z, p.x, p.y));
    return glm::vec3(0.5 + 0.35 * coarse + 0.1 * fine);
}

template <typename AnyCamera>
ByteImage picture_of(const AnyCamera& camera, const Pose& pose, const FloatImage& depth_m) {
    ByteImage rgb(camera.width, camera.height, 3);
    tbb::parallel_for(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x) {
            const glm::dvec3 ray = pose.orientation * camera.direction(x + 0.5, y + 0.5);
            const float depth = *depth_m.pixel(x, y);
            const glm::vec3 colour = colour_of(std::isinf(depth) ? ray : pose.position_m + double(depth) * ray);
            for (int c = 0; c < 3; ++c)
                rgb.pixel(x, y)[c] = std::uint8_t(255 * colour[c] + 0.5f);
        }
    });
    return rgb;
}

struct SeenEye {
    Pose pose;
    FloatImage depth_m{view.width, view.height, 1};
    ByteImage truth;
    EyePicture unfilled;

    EyeView eye() const { return {view, pose, depth_m.view()}; }
    double psnr_db(const EyePicture& filled) const {
        double squares = 0;
        std::int64_t samples = 0;
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                if (*unfilled.origin.pixel(x, y) != std::uint8_t(PixelOrigin::gap))
                    continue;
                for (int c = 0; c < 3; ++c, ++samples) {
                    const double difference = filled.rgba.pixel(x, y)[c] - truth.pixel(x, y)[c];
                    squares += difference * difference;
                }
            }
        return 10 * std::log10(255.0 * 255 * double(samples) / squares);
    }
};

struct Stage {
    Stage() {
        bench::BenchScene& scene = *bench::bench_scene("pavilion");
        const Pose head = scene.description.camera_path.at(0);
        const Pose source{head.position_m, {1, 0, 0, 0}};
        FloatImage depth_m(sphere.width, sphere.height, 1);
        scene.depth.cast(sphere, source, depth_m.view());
        const ByteImage rgb = picture_of(sphere, source, depth_m);
        const auto engine = make_engine("surface");
        main = {.camera = sphere, .pose = source, .box_radius_m = head_box_radius_centre(head_radius_m, default_ipd_m)};
        SourceView whole = main;
        whole.rgb = rgb.view();
        whole.depth_m = depth_m.view();
        engine->set_source(whole);
        Pose leaned = head;
        leaned.position_m += head.orientation * glm::dvec3(head_radius_m, 0, 0);
        for (const Eye side : {Eye::left, Eye::right}) {
            SeenEye& eye = eyes[side == Eye::left ? 0 : 1];
            eye.pose = {eye_position(leaned, side, default_ipd_m), head.orientation};
            scene.depth.cast(view, eye.pose, eye.depth_m.view());
            eye.truth = picture_of(view, eye.pose, eye.depth_m);
            engine->reproject(eye.eye(), eye.unfilled);
            gaps += eye.unfilled.count(PixelOrigin::gap);
        }
    }

    SourceView main;
    std::array<SeenEye, 2> eyes;
    std::int64_t gaps = 0;
};

const Stage& stage() {
    static const Stage only;
    return only;
}

void label(benchmark::State& state, const std::array<EyePicture, 2>& pictures) {
    char text[96];
    std::snprintf(text, sizeof text, "%.2f %% gaps, %.2f and %.2f dB in them",
                  50.0 * double(stage().gaps) / (double(view.width) * view.height),
                  stage().eyes[0].psnr_db(pictures[0]), stage().eyes[1].psnr_db(pictures[1]));
    state.SetLabel(text);
}

void ours(benchmark::State& state, const char* passes) {
    const FillChain chain = make_fill_chain(passes);
    for (const auto& fill_pass : chain)
        fill_pass->set_frame({.main = &stage().main});
    std::array<EyePicture, 2> pictures;
    for (auto _ : state) {
        state.PauseTiming();
        for (std::size_t i = 0; i < 2; ++i)
            pictures[i] = stage().eyes[i].unfilled;
        state.ResumeTiming();
        tbb::parallel_for(0, 2, [&](int i) { fill_gaps(chain, stage().eyes[i].eye(), pictures[i]); });
    }
    label(state, pictures);
}

#ifdef EQUISTREAM_WITH_OPENCV
void telea(benchmark::State& state) {
    std::array<EyePicture, 2> pictures;
    std::array<cv::Mat, 2> images, masks, filled;
    for (std::size_t i = 0; i < 2; ++i) {
        const EyePicture& unfilled = stage().eyes[i].unfilled;
        pictures[i] = unfilled;
        images[i] = cv::Mat(view.height, view.width, CV_8UC3);
        masks[i] = cv::Mat(view.height, view.width, CV_8UC1);
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x) {
                std::copy_n(unfilled.rgba.pixel(x, y), 3, images[i].ptr(y, x));
                *masks[i].ptr(y, x) = *unfilled.origin.pixel(x, y) == std::uint8_t(PixelOrigin::gap) ? 255 : 0;
            }
    }
    for (auto _ : state)
        for (std::size_t i = 0; i < 2; ++i)
            cv::inpaint(images[i], masks[i], filled[i], 3, cv::INPAINT_TELEA);
    for (std::size_t i = 0; i < 2; ++i)
        for (int y = 0; y < view.height; ++y)
            for (int x = 0; x < view.width; ++x)
                std::copy_n(filled[i].ptr(y, x), 3, pictures[i].rgba.pixel(x, y));
    label(state, pictures);
}
BENCHMARK(telea)->Name("fill_1080p/opencv_telea")->UseRealTime()->Unit(benchmark::kMillisecond);
#endif

BENCHMARK_CAPTURE(ours, pushpull, "pushpull")->Name("fill_1080p/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(ours, spread, "spread")->Name("fill_1080p/spread")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
