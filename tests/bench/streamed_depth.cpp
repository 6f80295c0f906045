/// Both eyes by the source's own depth: `mesh` beside the engines that do the same, on the CPU and on whatever
/// OpenGL finds. A sphere of 1920x960 and two eyes of 960x540, an IPD apart around its centre or 0.25 m beside that.
/// `cpu` and `gl_frame`: a new source with each picture. `gl_refresh`: the same source again, as between frames.
#include "bench_scene.h"

#include <client/gpu/context.h>
#include <client/warp/gl/eye_depth_finder.h>
#include <client/warp/gl/resample.h>

#include <client/stages/stages.h>
#include <equistream/bound.h>
#include <equistream/error.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <string>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{1920, 960, {}};
constexpr PerspectiveCamera window{960, 540, pi / 2};
constexpr double moved_m = 0.25;

struct Stage {
    FloatImage depth_m{sphere.width, sphere.height, 1};
    ByteImage rgb{sphere.width, sphere.height, 3};
    SourceView source;
    std::array<EyeView, 2> eyes;
    std::unique_ptr<gl::Context> context = gl::make_offscreen_context();
    gl::SourceTextures textures;
    gl::EyeTargets targets;
    gl::Resample resample{gl::ResampleRule::seen};

    Stage(bench::BenchScene& scene, double aside_m) {
        const Pose head = scene.description.camera_path.at(0);
        const Pose centre{head.position_m, {1, 0, 0, 0}};
        scene.depth.cast(sphere, centre, depth_m.view());
        for (int y = 0; y < sphere.height; ++y)
            for (int x = 0; x < sphere.width; ++x)
                for (int c = 0; c < 3; ++c)
                    rgb.pixel(x, y)[c] = static_cast<std::uint8_t>(x * (c + 1) + y);
        source = {.rgb = rgb.view(),
                  .camera = sphere,
                  .pose = centre,
                  .depth_m = depth_m.view(),
                  .box_radius_m = head_box_radius_centre(aside_m, default_ipd_m)};
        Pose at = head;
        at.position_m += head.orientation * glm::dvec3(aside_m, 0, 0);
        for (std::size_t i = 0; i < 2; ++i)
            eyes[i] = {window, {eye_position(at, i == 0 ? Eye::left : Eye::right, default_ipd_m), at.orientation}, {}};
        textures.upload(source);
        targets.size_for(window, 2);
    }
    ~Stage() { context->make_current(); }
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;
};

/// Kept to the end; null, and the figure left out, where there is no such scene or no OpenGL.
Stage* stage_of(benchmark::State& state, const std::string& name, double aside_m) {
    static std::map<std::pair<std::string, double>, std::unique_ptr<Stage>> all;
    std::unique_ptr<Stage>& stage = all[{name, aside_m}];
    try {
        if (stage)
            stage->context->make_current();
        else if (bench::BenchScene* scene = bench::bench_scene(name))
            stage = std::make_unique<Stage>(*scene, aside_m);
        else
            state.SkipWithError("EQUISTREAM_SCENES is not set");
    } catch (const InputError& error) {
        state.SkipWithError(error.what());
    }
    return stage.get();
}

void by_cpu(benchmark::State& state, const char* scene, double aside_m, const char* name) {
    Stage* stage = stage_of(state, scene, aside_m);
    if (stage == nullptr)
        return;
    const auto engine = make_engine(name);
    std::array<EyePicture, 2> pictures;
    for (auto _ : state) {
        engine->set_source(stage->source);
        tbb::parallel_for(std::size_t{0}, std::size_t{2},
                          [&](std::size_t i) { engine->reproject(stage->eyes[i], pictures[i]); });
        benchmark::DoNotOptimize(pictures[1].rgba.samples().data());
    }
}

void by_gl(benchmark::State& state, const char* scene, double aside_m, const char* name, bool new_source) {
    Stage* stage = stage_of(state, scene, aside_m);
    if (stage == nullptr)
        return;
    const auto finder = gl::make_eye_depth_from_source(name);
    const auto refresh = [&] {
        finder->find(stage->source, stage->textures, stage->eyes);
        stage->resample.reproject(stage->source, stage->textures, stage->eyes, finder->depth(), stage->targets);
        glFinish();
    };
    refresh();
    for (auto _ : state) {
        if (new_source)
            finder->forget_source();
        refresh();
    }
}

[[maybe_unused]] const bool added = [] {
    const auto add = [](const std::string& name, auto... arguments) {
        benchmark::RegisterBenchmark(name.c_str(), arguments...)->UseRealTime()->Unit(benchmark::kMillisecond);
    };
    for (const char* scene : {"pavilion", "sponza-crytek", "sibenik", "voxel-city", "kitchen", "san-miguel"})
        for (const double aside_m : {0.0, moved_m})
            for (const char* engine : {"mesh", "splat", "mesh-plain"}) {
                const std::string figure = std::string("streamed_") + scene + (aside_m > 0 ? "_moved_" : "_stereo_");
                const std::string side = std::string("/") + (engine == std::string("mesh") ? "ours" : engine);
                add(figure + "cpu" + side, by_cpu, scene, aside_m, engine);
                if (!find_engine(engine).on_gpu)
                    continue;
                add(figure + "gl_frame" + side, by_gl, scene, aside_m, engine, true);
                add(figure + "gl_refresh" + side, by_gl, scene, aside_m, engine, false);
            }
    return true;
}();

}  // namespace
