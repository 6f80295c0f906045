/// Two 1920x1080 eyes, an IPD apart around the centre of a 3840x1920 sphere: the `surface` engine with its gap masks,
/// both eyes side by side as `equistream play` has them, all depths given, against two of OpenCV's remaps (opencv.cpp)
/// and against a copy of both eyes' pictures.
#include "bench_scene.h"
#include "big_views.h"
#include "memory_copy.h"

#include <equistream/bound.h>
#include <equistream_client/engine.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <memory>

namespace {

using namespace equistream;

struct Stage {
    explicit Stage(bench::BenchScene& scene) {
        const Pose head = scene.description.camera_path.at(0);
        source_pose = {head.position_m, {1, 0, 0, 0}};
        scene.depth.cast(bench::big_sphere, source_pose, source_depth_m.view());
        for (int i = 0; i < 2; ++i) {
            eye_poses[i] = {eye_position(head, i == 0 ? Eye::left : Eye::right, default_ipd_m), head.orientation};
            scene.depth.cast(bench::big_view, eye_poses[i], eye_depths_m[i].view());
        }
    }
    SourceView source() const {
        return {.rgb = rgba.view(),
                .camera = bench::big_sphere,
                .pose = source_pose,
                .depth_m = source_depth_m.view(),
                .box_radius_m = head_box_radius_centre(0, default_ipd_m)};
    }

    ByteImage rgba = bench::big_picture(4);
    bench::BigPlanes planes;
    FloatImage source_depth_m{bench::big_sphere.width, bench::big_sphere.height, 1};
    FloatImage eye_depths_m[2] = {{bench::big_view.width, bench::big_view.height, 1},
                                  {bench::big_view.width, bench::big_view.height, 1}};
    Pose source_pose, eye_poses[2];
};

void two_eyes(benchmark::State& state, const char* name, bool planes) {
    bench::BenchScene* scene = bench::bench_scene(name);
    if (scene == nullptr)
        return state.SkipWithError("EQUISTREAM_SCENES is not set");
    const auto stage = std::make_unique<Stage>(*scene);
    SourceView source = stage->source();
    if (planes) {
        source.rgb = {};
        source.yuv = stage->planes.view();
    }
    const auto engine = make_engine("surface");
    EyePicture pictures[2];
    for (auto _ : state) {
        engine->set_source(source);
        tbb::parallel_for(0, 2, [&](int i) {
            engine->reproject(
                {.camera = bench::big_view, .pose = stage->eye_poses[i], .depth_m = stage->eye_depths_m[i].view()},
                pictures[i]);
        });
        benchmark::DoNotOptimize(pictures[1].rgba.samples().data());
    }
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
