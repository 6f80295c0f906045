/// How far each pixel of one 1920x1080 eye can be trusted, its picture and depth given, against a copy of what it reads
/// (colour and depth) and against making the picture (`eye-depth`).
#include "agreement.h"
#include "eye_stages.h"

#include <client/confidence/reliability.h>
#include <client/warp/engine.h>

#include <benchmark/benchmark.h>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere_camera{1920, 960, {}};
constexpr PerspectiveCamera eye_camera{1920, 1080, pi / 2};

/// With its picture made.
struct Stage : bench::EyeStage {
    Stage() : EyeStage(sphere_camera, eye_camera), engine(make_engine("surface")) {
        engine->set_source(source());
        engine->reproject(eye(), picture);
    }

    std::unique_ptr<Engine> engine;
    EyePicture picture;
};

Stage& stage() {
    static Stage made;
    return made;
}

void estimate(benchmark::State& state) {
    Stage& s = stage();
    for (auto _ : state) {
        estimate_reliability(s.source(), s.eye(), s.picture);
        benchmark::DoNotOptimize(s.picture.reliability.samples().data());
    }
}

void reproject(benchmark::State& state) {
    Stage& s = stage();
    EyePicture picture;
    for (auto _ : state) {
        s.engine->reproject(s.eye(), picture);
        benchmark::DoNotOptimize(picture.rgba.samples().data());
    }
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, std::size_t{eye_camera.width} * eye_camera.height * 8);
}

BENCHMARK(estimate)->Name("reliability_1920x1080/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(reproject)->Name("reliability_1920x1080/surface")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("reliability_1920x1080/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
