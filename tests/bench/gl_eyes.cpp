/// The same eyes as two_eyes.cpp's by OpenGL, on whatever it finds: `eye-depth` with its gap masks and `pushpull`, all
/// depths and colours there already, against the CPU's, a mesh of every sample and a backward search, which do without
/// masks and fill; and against parts of itself and the reliability map alone.
#include "eye_stages.h"
#include "gl_figures.h"
#include "gl_peers.h"

#include <client/confidence/gl/reliability_map.h>
#include <client/fill/gl/push_pull.h>
#include <client/gpu/context.h>
#include <client/warp/gl/resample.h>
#include <tests/support/targets_with_depth.h>

#include <client/fill/fill.h>
#include <client/warp/engine.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <memory>

namespace {

using namespace equistream;

struct GlEyes {
    bench::TwoEyesStage stage;
    SourceView source = stage.source();
    std::array<EyeView, 2> eyes = {stage.eye(0), stage.eye(1)};
    std::unique_ptr<gl::Context> context = gl::make_offscreen_context();
    gl::SourceTextures textures;
    gl::TargetsWithDepth targets;
    gl::Resample resample{gl::ResampleRule::seen, default_error_budget_px};
    gl::GapTiles gaps;
    gl::PushPull push_pull;
    gl::ReliabilityMap map;
    gl::SpecularTextures specular;
    bench::PeerTargets peer_targets{bench::big_view, 2};
    bench::MeshWarp mesh_warp{bench::big_sphere};
    bench::BackwardSearch backward_search;

    explicit GlEyes(bench::BenchScene& scene) : stage(scene) {
        textures.upload(source);
        targets.size_for(bench::big_view, 2);
        for (int i = 0; i < 2; ++i)
            targets.upload_depth(i, bench::big_view, eyes[std::size_t(i)].depth_m);
    }
    GlEyes(const GlEyes&) = delete;
    GlEyes& operator=(const GlEyes&) = delete;

    void reproject() { resample.reproject(source, textures, eyes, targets.depth(), targets); }
    void fill() {
        gaps.find(targets);
        push_pull.fill(source, eyes, targets.depth(), gaps, targets);
    }
    void judge() {
        const gl::EyeDepth depth = targets.depth();
        map.estimate({source, textures, specular}, {eyes, depth, targets});
    }
};

enum class Part { all, resample, fill, map, mesh_warp, backward_search };

void by_gl(benchmark::State& state, const char* name, Part part) {
    GlEyes* eyes = bench::gl_stage<GlEyes>(state, name, bench::bench_scene);
    if (eyes == nullptr)
        return;
    eyes->reproject();
    eyes->fill();
    for (auto _ : state) {
        if (part == Part::fill) {
            // Whose gaps are filled again, they must be gaps.
            state.PauseTiming();
            eyes->reproject();
            glFinish();
            state.ResumeTiming();
        }
        if (part == Part::all || part == Part::resample)
            eyes->reproject();
        if (part == Part::all || part == Part::fill)
            eyes->fill();
        if (part == Part::map)
            eyes->judge();
        if (part == Part::mesh_warp)
            eyes->mesh_warp.draw(eyes->source, eyes->textures, eyes->eyes, eyes->peer_targets);
        if (part == Part::backward_search)
            eyes->backward_search.draw(eyes->source, eyes->textures, eyes->eyes, eyes->peer_targets);
        glFinish();
    }
}

void by_cpu(benchmark::State& state, const char* name) {
    GlEyes* eyes = bench::gl_stage<GlEyes>(state, name, bench::bench_scene);
    if (eyes == nullptr)
        return;
    const SourceView& source = eyes->source;
    const auto engine = make_engine("surface");
    const FillChain chain = make_fill_chain("pushpull");
    chain[0]->set_frame({.main = &source});
    EyePicture pictures[2];
    for (auto _ : state) {
        engine->set_source(source);
        tbb::parallel_for(0, 2, [&](int i) {
            const EyeView& eye = eyes->eyes[std::size_t(i)];
            engine->reproject(eye, pictures[i]);
            chain[0]->fill(eye, pictures[i]);
        });
        benchmark::DoNotOptimize(pictures[1].rgba.samples().data());
    }
}

[[maybe_unused]] const bool added = [] {
    for (const char* scene : {"pavilion", "sponza-crytek"}) {
        const std::string figure = std::string("gl_eyes_1080p_") + scene;
        bench::add_gl_figure(figure + "/ours", by_gl, scene, Part::all);
        bench::add_gl_figure(figure + "/cpu", by_cpu, scene);
        bench::add_gl_figure(figure + "/mesh_warp", by_gl, scene, Part::mesh_warp);
        bench::add_gl_figure(figure + "/backward_search", by_gl, scene, Part::backward_search);
        bench::add_gl_figure(figure + "/look_up", by_gl, scene, Part::resample);
        bench::add_gl_figure(figure + "/push_pull", by_gl, scene, Part::fill);
        bench::add_gl_figure(figure + "/map", by_gl, scene, Part::map);
    }
    return true;
}();

}  // namespace
