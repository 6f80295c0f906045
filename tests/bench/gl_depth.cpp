/// Depth by OpenGL along a scene's path, 30 frames a second: what an eye of 960x540 looks up of a sphere of 1920x960
/// that is 31.5 mm beside it, against what that eye sees, what both eyes see, and the same as the paper draws it: one
/// draw of everything for an eye, six for a sphere and a seventh that turns the cube equirectangular.
#include "bench_scene.h"
#include "gl_figures.h"

#include <client/depth/gl/depth_pass.h>
#include <client/depth/gl/sphere_depth.h>
#include <client/gpu/context.h>
#include <client/warp/gl/source_textures.h>
#include <client/warp/view.h>
#include <equistream/bound.h>
#include <equistream/elapsed.h>

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>

namespace {

using namespace equistream;

const EquirectCamera sphere_camera{1920, 960, {}};
const PerspectiveCamera eye_camera{960, 540, pi / 2};
constexpr int warm_up_frames = 3;

/// A scene's geometry in a context of its own; kept to the end.
struct Drawing {
    explicit Drawing(const SceneDescription& scene)
        : description(scene), context(gl::make_offscreen_context()), pass(load_model(description, {.shading = false})),
          sphere_depth(head_box_radius_centre(description.head_radius_m, default_ipd_m),
                       default_budget_share * error_budget_rad(default_focal_length_px)) {}
    Drawing(const Drawing&) = delete;
    Drawing& operator=(const Drawing&) = delete;

    SceneDescription description;
    std::unique_ptr<gl::Context> context;
    gl::DepthPass pass;
    gl::SphereDepth sphere_depth;
    gl::SourceTextures source;
};

Pose head_at(const Drawing& drawing, int frame) {
    const PosePath& path = drawing.description.camera_path;
    return path.at(std::fmod(frame / 30.0, std::max(path.duration_s(), 1 / 30.0)));
}

Pose eye_pose(const Pose& head, Eye eye) {
    return camera_pose(eye_camera, head, eye, default_ipd_m, AxisLock::world);
}

void draw_eye(Drawing& drawing, const Pose& head, gl::Culling culling) {
    const gl::DepthViewpoint view{eye_camera, eye_pose(head, Eye::left)};
    drawing.pass.draw({&view, 1}, culling);
}

void draw_eyes(Drawing& drawing, const Pose& head, gl::Culling culling) {
    const std::array<gl::DepthViewpoint, 2> views = {
        {{eye_camera, eye_pose(head, Eye::left)}, {eye_camera, eye_pose(head, Eye::right)}}};
    drawing.pass.draw(views, culling);
}

void draw_sphere(Drawing& drawing, const Pose& head, gl::Culling culling) {
    const Pose centre{head.position_m, {1, 0, 0, 0}};
    const EyeView eye{.camera = eye_camera, .pose = eye_pose(head, Eye::left)};
    const gl::SphereViews views = culling == gl::Culling::nothing ? gl::cube_views(sphere_camera, centre)
                                                                  : gl::sphere_views(sphere_camera, centre, {&eye, 1});
    drawing.pass.draw(views.views, culling);
    drawing.source.describe(sphere_camera);
    drawing.source.forget_depth();
    drawing.sphere_depth.resolve(drawing.pass, 0, views, centre, drawing.source);
}

using Draw = void (*)(Drawing&, const Pose&, gl::Culling);

void along_the_path(benchmark::State& state, const std::string& scene, Draw draw, gl::Culling culling) {
    Drawing* drawing = bench::gl_stage<Drawing>(state, scene, bench::bench_description);
    if (drawing == nullptr)
        return;
    int frame = 0;
    for (; frame < warm_up_frames; ++frame)
        draw(*drawing, head_at(*drawing, frame), culling);
    glFinish();
    std::uint64_t triangles = 0, frames = 0;
    for (auto _ : state) {
        const auto start = Clock::now();
        draw(*drawing, head_at(*drawing, frame), culling);
        glFinish();
        state.SetIterationTime(milliseconds_since(start) / 1000);
        triangles += drawing->pass.drawn().triangles;
        ++frame;
        ++frames;
    }
    state.SetLabel(std::to_string(triangles / frames) + " triangles drawn a frame of " +
                   std::to_string(drawing->pass.triangle_count()) + " (" + gl::Context::driver().renderer + ")");
}

[[maybe_unused]] const bool added = [] {
    for (const char* scene : {"pavilion", "voxel-city", "san-miguel"}) {
        const auto add = [&](const std::string& side, Draw draw, gl::Culling culling) {
            benchmark::RegisterBenchmark(("gl_depth_" + std::string(scene) + "/" + side).c_str(), along_the_path,
                                         std::string(scene), draw, culling)
                ->UseManualTime()
                ->MeasureProcessCPUTime()
                ->Unit(benchmark::kMillisecond);
        };
        add("ours", draw_sphere, gl::Culling::hidden);
        add("eye", draw_eye, gl::Culling::hidden);
        add("both_eyes", draw_eyes, gl::Culling::hidden);
        add("paper_7_draws", draw_sphere, gl::Culling::nothing);
        add("paper_1_draw", draw_eye, gl::Culling::nothing);
    }
    return true;
}();

}  // namespace
