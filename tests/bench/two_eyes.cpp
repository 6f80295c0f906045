/// Two 1920x1080 eyes, an IPD apart around the centre of a 3840x1920 sphere, or of a window of it that they look at:
/// the `eye-depth` engine with its gap masks, both eyes side by side as `equistream play` has them, all depths given,
/// against two of OpenCV's remaps (opencv.cpp) and against a copy of both eyes' pictures.
#include "agreement.h"
#include "eye_stages.h"

#include <client/warp/engine.h>
#include <equistream/window.h>

#include <benchmark/benchmark.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <memory>

namespace {

using namespace equistream;

enum class From { rgb, planes, window };

template <typename T>
ImageView<const T> part(const ImageView<const T>& plane, const WindowGrid& grid, WindowPlace place) {
    const int shrunk = grid.columns / plane.width;
    return {plane.pixel(place.x / shrunk, place.y / shrunk), grid.width / shrunk, grid.height / shrunk, plane.channels,
            plane.row_stride};
}

/// A window of 1920x1440 pixels of the sphere, around the gaze, as far from the seam as it must be to lie in one piece.
SourceView window_of(SourceView sphere, const glm::dquat& head) {
    const WindowGrid grid{bench::big_sphere.width, bench::big_sphere.height, 1920, 1440};
    WindowPlace place = window_around(grid, glm::conjugate(sphere.pose.orientation) * head * glm::dvec3(0, 0, -1));
    place.x = std::min(place.x, grid.columns - grid.width);
    sphere.camera = window_camera(grid, place);
    sphere.yuv = {part(sphere.yuv.y, grid, place), part(sphere.yuv.cb, grid, place), part(sphere.yuv.cr, grid, place)};
    sphere.depth_m = part(sphere.depth_m, grid, place);
    return sphere;
}

void two_eyes(benchmark::State& state, const char* name, From from) {
    bench::BenchScene* scene = bench::bench_scene(name);
    if (scene == nullptr)
        return state.SkipWithError("EQUISTREAM_SCENES is not set");
    const auto stage = std::make_unique<bench::TwoEyesStage>(*scene);
    SourceView source = stage->source();
    if (from != From::rgb) {
        source.rgb = {};
        source.yuv = stage->planes.view();
    }
    if (from == From::window)
        source = window_of(source, stage->eye(0).pose.orientation);
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
        add(figure + "/ours", two_eyes, scene, From::rgb);
        add(figure + "/ours_from_planes", two_eyes, scene, From::planes);
        add(figure + "/ours_from_window", two_eyes, scene, From::window);
        add(figure + "/memcpy", copy);
    }
    return true;
}();

}  // namespace
