/// How far each pixel of one 1920x1080 eye can be trusted, its picture and depth given, against a copy of what it reads
/// (colour and depth) and against making the picture (`surface`).
#include "bench_scene.h"
#include "memory_copy.h"

#include <equistream/bound.h>
#include <equistream_client/engine.h>
#include <equistream_client/reliability.h>

#include <benchmark/benchmark.h>

namespace {

using namespace equistream;

constexpr EquirectCamera sphere{1920, 960, {}};
constexpr PerspectiveCamera view{1920, 1080, pi / 2};

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
                    rgb.pixel(x, y)[c] = static_cast<std::uint8_t>((x ^ y) * (c + 1));
        engine = make_engine("surface");
        engine->set_source(source());
        engine->reproject(eye(), picture);
    }
    SourceView source() const {
        return {.rgb = rgb.view(),
                .camera = sphere,
                .pose = source_pose,
                .depth_m = source_depth_m.view(),
                .box_radius_m = head_box_radius_centre(0, default_ipd_m)};
    }
    EyeView eye() const { return {.camera = view, .pose = eye_pose, .depth_m = eye_depth_m.view()}; }

    Pose source_pose, eye_pose;
    ByteImage rgb{sphere.width, sphere.height, 3};
    FloatImage source_depth_m{sphere.width, sphere.height, 1};
    FloatImage eye_depth_m{view.width, view.height, 1};
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
    bench::copy_bytes(state, std::size_t{view.width} * view.height * 8);
}

BENCHMARK(estimate)->Name("reliability_1920x1080/ours")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(reproject)->Name("reliability_1920x1080/surface")->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(copy)->Name("reliability_1920x1080/memcpy")->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
