/// One 640x360 eye, half an IPD beside a 1280x640 sphere of the bundled scene: the `surface` engine, its depths given,
/// against turning the sphere (`sphere`) and against a copy of the eye's picture.
#include "bench_scene.h"
#include "memory_copy.h"

#include <equistream/bound.h>
#include <equistream_client/engine.h>

#include <benchmark/benchmark.h>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{1280, 640, {}};
constexpr PerspectiveCamera view{640, 360, pi / 2};

/// A sphere and an eye of the bundled scene, each with its depth.
struct Stage {
    Stage() {
        bench::BenchScene& scene = *bench::bench_scene("pavilion");
        const Pose head = scene.description.camera_path.at(0);
        source_pose = {head.position_m, {1, 0, 0, 0}};
        eye_pose = {eye_position(head, Eye::left, default_ipd_m), head.orientation};
        scene.depth.cast(sphere, source_pose, source_depth_m.view());
        scene.depth.cast(view, eye_pose, eye_depth_m.view());
        for (int y = 0; y < sphere.height; ++y)
            for (int x = 0; x < sphere.width; ++x)
                for (int c = 0; c < 3; ++c)
                    rgb.pixel(x, y)[c] = static_cast<std::uint8_t>(x * (c + 1) + y);
    }
    SourceView source() const {
        return {.rgb = rgb.view(),
                .camera = sphere,
                .pose = source_pose,
                .depth_m = source_depth_m.view(),
                .box_radius_m = head_box_radius_centre(0, default_ipd_m)};
    }

    Pose source_pose, eye_pose;
    ByteImage rgb{sphere.width, sphere.height, 3};
    FloatImage source_depth_m{sphere.width, sphere.height, 1};
    FloatImage eye_depth_m{view.width, view.height, 1};
};

void reproject(benchmark::State& state, const char* engine_name) {
    static const Stage stage;
    const auto engine = make_engine(engine_name);
    engine->set_source(stage.source());
    EyePicture picture;
    for (auto _ : state) {
        engine->reproject({.camera = view, .pose = stage.eye_pose, .depth_m = stage.eye_depth_m.view()}, picture);
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
