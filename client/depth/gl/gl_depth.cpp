#include "gl_depth.h"

#include "depth_pass.h"
#include "sphere_depth.h"

#include <client/gpu/context.h>
#include <equistream/error.h>

#include <tbb/parallel_for.h>

#include <cassert>
#include <mutex>
#include <vector>

namespace equistream {

namespace {

/// Eyes whose look-ups are told apart from all others; where more are cast, spheres are drawn whole.
constexpr std::size_t max_remembered = 4;

/// Radial distances of a flat view's planar ones; the two have one size.
void to_radial(const PerspectiveCamera& camera, ImageView<float> depth_m) {
    tbb::parallel_for(0, depth_m.height, [&](int y) {
        for (int x = 0; x < depth_m.width; ++x) {
            float& sample = depth_m.pixel(x, y)[0];
            const double forward = -camera.direction(x + 0.5, y + 0.5).z;
            sample = float(1 / (double(sample) * double(gl::DepthPass::inverse_scale()) * forward));
        }
    });
}

std::size_t row_bytes(const ImageView<float>& depth_m) {
    return std::size_t(depth_m.row_stride) * sizeof(float);
}

}  // namespace

struct GlDepth::State {
    /// What lives in the context.
    struct Drawing {
        Drawing(const SceneModel& model, double box_radius_m, double error_rad)
            : pass(model), sphere_depth(box_radius_m, error_rad) {}

        gl::DepthPass pass;
        gl::SphereDepth sphere_depth;
        gl::SourceTextures source;
    };

    SceneDescription scene;
    GlDepthOptions options;
    SceneModel model;
    std::vector<std::uint32_t> movers;
    std::unique_ptr<gl::Context> context;
    std::unique_ptr<Drawing> drawing;
    std::vector<EyeView> eyes;
    GlDepthFigures figures;
    mutable std::mutex mutex;

    State(const SceneDescription& description, const GlDepthOptions& gl_options)
        : scene(description), options(gl_options), model(load_model(description, {.shading = false})),
          movers(find_moving_instances(model, scene)) {
        const gl::KeptContext before;
        context = gl::make_offscreen_context();
        const double box_radius_m = options.box_radius_m > 0
                                        ? options.box_radius_m
                                        : head_box_radius_centre(scene.head_radius_m, default_ipd_m);
        drawing = std::make_unique<Drawing>(model, box_radius_m, options.error_rad);
    }
    ~State() {
        try {
            const gl::Current current(*context);
            drawing.reset();
        } catch (const WorkError&) {
            // Nothing can be freed one by one; the context, which goes now, has it all.
            static_cast<void>(drawing.release());
        }
    }
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    void cast_view(const PerspectiveCamera& camera, const Pose& pose, ImageView<float> depth_m) {
        const gl::DepthViewpoint view{camera, pose};
        drawing->pass.draw({&view, 1});
        figures.views = 1;
        gl::download(drawing->pass.texture(), 0, {camera.width, camera.height},
                     {GL_DEPTH_COMPONENT, GL_FLOAT, sizeof(float)}, depth_m.data, row_bytes(depth_m));
        to_radial(camera, depth_m);
        if (eyes.size() <= max_remembered)
            eyes.push_back({camera, pose});
    }

    void cast_sphere(const EquirectCamera& camera, const Pose& pose, ImageView<float> depth_m) {
        const bool whole = options.cube || eyes.empty() || eyes.size() > max_remembered;
        const gl::SphereViews views = whole ? gl::cube_views(camera, pose) : gl::sphere_views(camera, pose, eyes);
        drawing->pass.draw(views.views, options.cube ? gl::Culling::nothing : gl::Culling::hidden);
        figures.views = int(views.views.size());
        drawing->source.describe(camera);
        drawing->source.forget_depth();
        drawing->sphere_depth.resolve(drawing->pass, 0, views, pose, drawing->source);
        gl::download(drawing->source.depth(), 0, drawing->source.size(), {GL_RED, GL_FLOAT, sizeof(float)},
                     depth_m.data, row_bytes(depth_m));
    }
};

GlDepth::GlDepth(const SceneDescription& scene, const GlDepthOptions& options)
    : state_(std::make_unique<State>(scene, options)) {
    set_time(0);
}

GlDepth::~GlDepth() = default;

std::string_view GlDepth::name() const {
    return state_->options.cube ? "gl-cube" : "gl";
}

void GlDepth::set_time(double time_s) {
    const std::lock_guard lock(state_->mutex);
    state_->eyes.clear();
    if (state_->movers.empty())
        return;
    const gl::Current current(*state_->context);
    state_->drawing->pass.set_transforms(instance_transforms(state_->model, state_->scene, time_s));
}

void GlDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    assert(depth_m.width == width_of(camera) && depth_m.height == height_of(camera) && depth_m.channels == 1);
    const std::lock_guard lock(state_->mutex);
    const gl::Current current(*state_->context);
    if (const auto* flat = std::get_if<PerspectiveCamera>(&camera))
        state_->cast_view(*flat, pose, depth_m);
    else
        state_->cast_sphere(std::get<EquirectCamera>(camera), pose, depth_m);
    state_->figures.triangles = state_->drawing->pass.drawn().triangles;
}

std::string GlDepth::driver() const {
    const std::lock_guard lock(state_->mutex);
    const gl::Current current(*state_->context);
    return gl::Context::driver().renderer;
}

GlDepthFigures GlDepth::figures() const {
    const std::lock_guard lock(state_->mutex);
    return state_->figures;
}

}  // namespace equistream
