/// What both eyes of a small window see by the frame's own depth (engine `mesh`), its look-up included, on whatever
/// OpenGL finds: at each refresh, the mesh kept; at each frame, which has it built anew; and by the CPU.
#include "eye_stage.h"

#include <gl/context.h>
#include <reproject/gl/look_up.h>
#include <reproject/gl/mesh_depth.h>

#include <equistream/error.h>
#include <equistream_client/engine.h>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <memory>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{2048, 1024, {}};
constexpr PerspectiveCamera window{640, 360, pi / 2};

struct Stage {
    bench::EyeStage stage{sphere, window};
    SourceView source = stage.source();
    std::array<EyeView, 2> eyes;
    std::unique_ptr<gl::Context> context = gl::make_offscreen_context();
    std::array<gl::SourceTextures, 2> textures;  // whose depths are others throughout
    gl::EyeTargets targets;
    gl::MeshDepth mesh;
    gl::LookUp look_up{gl::LookUpRule::seen};

    Stage() {
        const Pose head = bench::bench_scene("pavilion")->description.camera_path.at(0);
        for (std::size_t i = 0; i < 2; ++i)
            eyes[i] = {
                window, {eye_position(head, i == 0 ? Eye::left : Eye::right, default_ipd_m), head.orientation}, {}};
        textures[0].upload(source);
        FloatImage farther_m(sphere.width, sphere.height, 1);
        for (int y = 0; y < sphere.height; ++y)
            std::transform(source.depth_m.row(y), source.depth_m.row(y) + sphere.width, farther_m.pixel(0, y),
                           [](float r) { return 1.0001f * r; });
        SourceView farther = source;
        farther.depth_m = farther_m.view();
        textures[1].upload(farther);
        targets.size_for(window, 2);
    }
    ~Stage() { context->make_current(); }  // where all that goes now lives
    Stage(const Stage&) = delete;
    Stage& operator=(const Stage&) = delete;
};

enum class Part { refresh, frame, depth_alone };

/// Kept to the end; null, and the benchmark left out, where there is no OpenGL.
Stage* stage_of(benchmark::State& state) {
    static std::unique_ptr<Stage> stage;
    try {
        if (stage)
            stage->context->make_current();  // other figures have contexts of their own
        else
            stage = std::make_unique<Stage>();
    } catch (const InputError& error) {
        state.SkipWithError(error.what());
    }
    return stage.get();
}

void by_gl(benchmark::State& state, Part part) {
    Stage* stage = stage_of(state);
    if (stage == nullptr)
        return;
    std::size_t shown = 0;
    const auto refresh = [&] {
        const gl::SourceTextures& textures = stage->textures[shown];
        stage->mesh.find(stage->source, textures, stage->eyes);
        if (part != Part::depth_alone)
            stage->look_up.reproject(stage->source, textures, stage->eyes, stage->mesh.depth(), stage->targets);
        glFinish();
    };
    stage->mesh.forget_source();
    refresh();
    for (auto _ : state) {
        if (part == Part::frame) {
            shown = 1 - shown;
            stage->mesh.forget_source();
        }
        refresh();
    }
}

void by_cpu(benchmark::State& state) {
    Stage* stage = stage_of(state);
    if (stage == nullptr)
        return;
    const auto engine = make_engine("mesh");
    EyePicture picture;
    for (auto _ : state) {
        engine->set_source(stage->source);
        for (const EyeView& eye : stage->eyes)
            engine->reproject(eye, picture);
        benchmark::DoNotOptimize(picture.rgba.samples().data());
    }
}

[[maybe_unused]] const bool added = [] {
    const auto add = [](const char* name, auto... arguments) {
        benchmark::RegisterBenchmark(name, arguments...)
            ->UseRealTime()
            ->MeasureProcessCPUTime()
            ->Unit(benchmark::kMillisecond);
    };
    add("gl_mesh_640x360/ours", by_gl, Part::refresh);
    add("gl_mesh_640x360/depth_alone", by_gl, Part::depth_alone);
    add("gl_mesh_640x360/frame", by_gl, Part::frame);
    add("gl_mesh_640x360/cpu", by_cpu);
    return true;
}();

}  // namespace
