#include <equistream_client/gl_depth.h>

#include "depth_pass.h"
#include "sphere_depth.h"
#include "sphere_views.h"

#include <equistream_client/engine.h>
#include <gl/context.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <mutex>
#include <optional>
#include <vector>

namespace equistream {

namespace {

/// Those cast since the time was set; a few more than a pair of eyes, for whoever asks for other views too.
constexpr std::size_t most_remembered = 4;

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

}  // namespace

struct GlDepth::State {
    SceneDescription scene;
    GlDepthOptions options;
    SceneModel model;
    std::vector<std::uint32_t> movers;
    std::unique_ptr<gl::Context> context;
    std::optional<gl::DepthPass> pass;
    std::optional<gl::SphereDepth> sphere_depth;
    std::optional<gl::SourceTextures> source;
    std::vector<EyeView> eyes;
    GlDepthFigures figures;
    std::mutex drawing;

    State(const SceneDescription& description, const GlDepthOptions& gl_options)
        : scene(description), options(gl_options), model(load_model(description, {.shading = false})),
          movers(find_moving_instances(model, scene)), context(gl::make_offscreen_context()) {
        pass.emplace(model);
        sphere_depth.emplace();
        source.emplace();
        context->release();
    }
    ~State() {
        context->make_current();
        source.reset();
        sphere_depth.reset();
        pass.reset();
    }

    void cast_view(const PerspectiveCamera& camera, const Pose& pose, ImageView<float> depth_m) {
        const gl::DepthViewpoint view{camera, pose};
        pass->draw({&view, 1});
        figures.views = 1;
        glPixelStorei(GL_PACK_ROW_LENGTH, GLint(depth_m.row_stride));
        glGetTextureSubImage(pass->texture(), 0, 0, 0, 0, camera.width, camera.height, 1, GL_DEPTH_COMPONENT, GL_FLOAT,
                             GLsizei(std::size_t(depth_m.row_stride) * std::size_t(depth_m.height) * sizeof(float)),
                             depth_m.data);
        glPixelStorei(GL_PACK_ROW_LENGTH, 0);
        to_radial(camera, depth_m);
        if (eyes.size() < most_remembered)
            eyes.push_back({camera, pose});
    }

    void cast_sphere(const EquirectCamera& camera, const Pose& pose, ImageView<float> depth_m) {
        const gl::SphereViews views =
            options.cube || eyes.empty() ? gl::cube_views(camera, pose) : gl::sphere_views(camera, pose, eyes);
        pass->draw(views.views);
        figures.views = int(views.views.size());
        source->describe(camera);
        source->forget_depth();
        sphere_depth->resolve(*pass, 0, views, pose, *source);
        glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
        glPixelStorei(GL_PACK_ROW_LENGTH, GLint(depth_m.row_stride));
        glGetTextureImage(source->depth(), 0, GL_RED, GL_FLOAT,
                          GLsizei(std::size_t(depth_m.row_stride) * std::size_t(depth_m.height) * sizeof(float)),
                          depth_m.data);
        glPixelStorei(GL_PACK_ROW_LENGTH, 0);
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
    const std::lock_guard lock(state_->drawing);
    state_->eyes.clear();
    if (state_->movers.empty())
        return;
    const gl::Current current(*state_->context);
    state_->pass->set_transforms(instance_transforms(state_->model, state_->scene, time_s));
}

void GlDepth::cast(const Camera& camera, const Pose& pose, ImageView<float> depth_m) {
    assert(depth_m.width == width_of(camera) && depth_m.height == height_of(camera) && depth_m.channels == 1);
    const std::lock_guard lock(state_->drawing);
    const gl::Current current(*state_->context);
    if (const auto* flat = std::get_if<PerspectiveCamera>(&camera))
        state_->cast_view(*flat, pose, depth_m);
    else
        state_->cast_sphere(std::get<EquirectCamera>(camera), pose, depth_m);
    state_->figures.triangles = state_->pass->drawn().triangles;
}

std::string GlDepth::driver() const {
    const std::lock_guard lock(state_->drawing);
    const gl::Current current(*state_->context);
    return gl::Context::driver().renderer;
}

GlDepthFigures GlDepth::figures() const {
    return state_->figures;
}

}  // namespace equistream
