/// Two 1920x1080 eyes, an IPD apart around the centre of a 3840x1920 sphere: the `eye-depth` engine with its gap masks,
/// both eyes side by side as `equistream play` has them, all depths given, against two of OpenCV's remaps (opencv.cpp)
/// and against a copy of both eyes' pictures.
#include "agreement.h"
#include "eye_stages.h"

#include <client/warp/engine.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <memory>

namespace {

using namespace equistream;

void two_eyes(benchmark::State& state, const char* name, bool planes) {
    bench::BenchScene* scene = bench::bench_scene(name);
    if (scene == nullptr)
        return state.SkipWithError("EQUISTREAM_SCENES is not set");
    const auto stage = std::make_unique<bench::TwoEyesStage>(*scene);
    SourceView source = stage->source();
    if (planes) {
        source.rgb = {};
        source.yuv = stage->planes.view();
    }
    const auto engine = make_engine("surface");
    EyePicture pictures[2];
    for (auto _ : state) {
        engine->set_source(source);
        tbb::parallel_for(0, 2, [&](int i) { engine->reproject(stage->eye(std::size_t(i)), pictures[i]); });
        benchmark::DoNotOptimize(pictures[1].rgba.samples().data());
    }
    state.SetLabel(bench::agreement_label("surface", source, stage->eye(1), pictures[1]));
}

void copy(benchmark::State& state) {
    bench::copy_bytes(state, std::size_t{2} * bench::big_view.width * bench::big_view.height * 4);
}

[[maybe_unused]] const bool added = [] {
    const auto add = [](const std::string& name, auto... arguments) {
        benchmark::RegisterBenchmark(name.c_str(), arguments...)->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    for (const char* scene : {"pavilion", "sponza-crytek"}) {
        const std::string figure = std::string("two_eyes_1080p_") + scene;
        add(figure + "/ours", two_eyes, scene, false);
        add(figure + "/ours_from_planes", two_eyes, scene, true);
        add(figure + "/memcpy", copy);
    }
    return true;
}();

}  // namespace
