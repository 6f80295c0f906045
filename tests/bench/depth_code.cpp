/// Depth of a 3840x1920 sphere to a code's samples and back, against a copy of the same bytes: what is read and what is
/// written, half each.
#include "bench_scene.h"

#include <equistream/bound.h>
#include <equistream/depth_code.h>
#include <equistream/error.h>

#include <client/gpu/context.h>
#include <client/stages/stages.h>
#include <client/warp/gl/eye_depth_finder.h>
#include <client/warp/gl/resample.h>
#include <tests/support/planes.h>

#include <benchmark/benchmark.h>
#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace {

using namespace equistream;

constexpr int width = 3840, height = 1920;
constexpr int threads = 2;
constexpr DepthRange range{0.0315, 0.3, false};

/// A floor, walls and a sky.
FloatImage some_depth() {
    FloatImage depth_m(width, height, 1);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            depth_m.pixel(x, y)[0] = y < height / 4 ? HUGE_VALF : 0.3f + float((x * 7 + y * 13) % 4096) * 0.01f;
    return depth_m;
}

std::size_t bytes_of(const PlaneFormat& format) {
    std::size_t samples = 0;
    for (int i = 0; i < format.plane_count(); ++i)
        samples += std::size_t(width / format.step(i)) * std::size_t(height / format.step(i));
    return samples * (format.bits == 8 ? 1 : 2);
}

void pack(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto code = make_depth_code(name);
    const FloatImage depth_m = some_depth();
    Planes planes(code->format(), width, height);
    for (auto _ : state) {
        code->pack(depth_m.view(), range, planes.view());
        benchmark::ClobberMemory();
    }
}

void unpack(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const auto code = make_depth_code(name);
    FloatImage depth_m = some_depth();
    Planes planes(code->format(), width, height);
    code->pack(depth_m.view(), range, planes.view());
    for (auto _ : state) {
        code->unpack(planes.view(), range, depth_m.view());
        benchmark::ClobberMemory();
    }
}

void copy(benchmark::State& state, const char* name) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    const std::size_t bytes =
        (std::size_t(width) * height * sizeof(float) + bytes_of(make_depth_code(name)->format())) / 2;
    std::vector<char> from(bytes, 1), to(bytes);
    for (auto _ : state) {
        tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bytes, 1 << 18), [&](const auto& part) {
            std::memcpy(to.data() + part.begin(), from.data() + part.begin(), part.size());
        });
        benchmark::ClobberMemory();
    }
}

void in_milliseconds(benchmark::internal::Benchmark* benchmark) {
    benchmark->UseRealTime()->Unit(benchmark::kMillisecond);
}

[[maybe_unused]] const bool registered = [] {
    for (const char* name : {"w8", "w10", "w12", "pece444", "pece420", "hue", "lossless"}) {
        const std::string figure = std::string("_") + name;
        in_milliseconds(benchmark::RegisterBenchmark(("depth_pack" + figure + "/ours").c_str(), pack, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_pack" + figure + "/memcpy").c_str(), copy, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_unpack" + figure + "/ours").c_str(), unpack, name));
        in_milliseconds(benchmark::RegisterBenchmark(("depth_unpack" + figure + "/memcpy").c_str(), copy, name));
    }
    return true;
}();

}  // namespace

// Both eyes by the source's own depth: `mesh` beside the engines that do the same, on the CPU and on whatever
// OpenGL finds. A sphere of 1920x960 and two eyes of 960x540, an IPD apart around its centre or 0.25 m beside that.
// `cpu` and `gl_frame`: a new source with each picture. `gl_refresh`: the same source again, as between frames.

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
    gl::Resample resample{gl::ResampleRule::seen, EngineOptions{}.budget_px_of("mesh")};

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
