#pragma once
/// What figures of OpenGL share: a stage for each scene, in a context of its own, and how it is timed.
#include <client/gpu/context.h>

#include <benchmark/benchmark.h>

#include <exception>
#include <map>
#include <memory>
#include <string>

namespace equistream::bench {

/// The scene's, made of what `find` (bench_scene, bench_description) gives, and kept; its context is current until the
/// next call. Null, and the benchmark left out, where there is no such scene or no OpenGL.
template <typename Stage, typename Find>
Stage* gl_stage(benchmark::State& state, const std::string& scene, const Find& find) {
    // Never freed: the driver is gone before static objects are.
    static auto& stages = *new std::map<std::string, std::unique_ptr<Stage>>;
    std::unique_ptr<Stage>& stage = stages[scene];
    try {
        if (stage)
            stage->context->make_current();
        else if (const auto found = find(scene))
            stage = std::make_unique<Stage>(*found);
        else
            state.SkipWithError("EQUISTREAM_SCENES is not set");
    } catch (const std::exception& error) {
        state.SkipWithError(error.what());
    }
    return stage.get();
}

template <typename... Arguments>
void add_gl_figure(const std::string& name, Arguments... arguments) {
    benchmark::RegisterBenchmark(name.c_str(), arguments...)
        ->UseRealTime()
        ->MeasureProcessCPUTime()
        ->Unit(benchmark::kMillisecond);
}

}  // namespace equistream::bench
