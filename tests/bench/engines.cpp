/// One 1920x1080 eye, half an IPD beside a 3840x1920 sphere of the bundled scene: the engines that find the eye's depth
/// themselves against `surface`, which is given it. Below 1: by how many times such an engine is slower.
#include "big_views.h"
#include "eye_stage.h"

#include <equistream_client/engine.h>

#include <benchmark/benchmark.h>

#include <string>

namespace {

using namespace equistream;

void reproject(benchmark::State& state, const char* engine_name) {
    static const bench::EyeStage stage(bench::big_sphere, bench::big_view);
    const auto engine = make_engine(engine_name);
    EyePicture picture;
    for (auto _ : state) {
        engine->set_source(stage.source());
        engine->reproject(stage.eye(), picture);
        benchmark::DoNotOptimize(picture.rgba.samples().data());
    }
}

[[maybe_unused]] const bool added = [] {
    for (const char* name : {"splat", "mesh", "gather"}) {
        const std::string figure = std::string(name) + "_1080p";
        for (const auto& [side, engine] : {std::pair{"ours", name}, {"surface", "surface"}})
            benchmark::RegisterBenchmark((figure + "/" + side).c_str(), reproject, engine)
                ->UseRealTime()
                ->Unit(benchmark::kMillisecond);
    }
    return true;
}();

}  // namespace
