/// One 640x360 eye, half an IPD beside a 1280x640 sphere of the bundled scene: the `eye-depth` engine, its depths
/// given, against turning the sphere (`rotation`) and against a copy of the eye's picture.
#include "agreement.h"
#include "eye_stages.h"

#include <client/warp/engine.h>

#include <benchmark/benchmark.h>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{1280, 640, {}};
constexpr PerspectiveCamera view{640, 360, pi / 2};

void reproject(benchmark::State& state, const char* engine_name) {
    static const bench::EyeStage stage(sphere, view);
    const auto engine = make_engine(engine_name);
    engine->set_source(stage.source());
    EyePicture picture;
    for (auto _ : state) {
        engine->reproject(stage.eye(), picture);
        benchmark::DoNotOptimize(picture.rgba.samples().data());
    }
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, std::size_t{view.width} * view.height * 4);
}

BENCHMARK_CAPTURE(reproject, surface, "surface")
    ->Name("surface_640x360/ours")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(reproject, sphere, "sphere")
    ->Name("surface_640x360/sphere_rotation")
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("surface_640x360/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
