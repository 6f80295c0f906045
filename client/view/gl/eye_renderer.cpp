#include "eye_renderer.h"

#include <depth/gl/sphere_views.h>

#include <equistream/bound.h>

#include <cassert>
#include <utility>
#include <variant>
#include <vector>

namespace equistream::gl {

namespace {

/// What was seen longer ago, or (after a jump in time) later, is no part of the same walk.
constexpr double longest_memory_s = 1;

}  // namespace

/// The client's own geometry, where it is at the time of the frame that is shown.
struct EyeRenderer::Geometry {
    Geometry(const SceneDescription& description, const SceneModel& loaded, double box_radius_m)
        : scene(description), model(loaded), moves(!find_moving_instances(model, scene).empty()), pass(model),
          sphere_depth(box_radius_m, default_budget_share * error_budget_rad(default_focal_length_px)) {
        model.meshes = {};  // instances are all that is needed from now on
    }

    void set_time(double time_s) {
        if (moves)
            pass.set_transforms(instance_transforms(model, scene, time_s));
    }

    SceneDescription scene;
    SceneModel model;
    bool moves;
    DepthPass pass;
    SphereDepth sphere_depth;
    std::vector<DepthViewpoint> views;
};

EyeRenderer::EyeRenderer(const SceneDescription* scene, double box_radius_m) : turn_(false), surface_(true) {
    if (scene != nullptr)
        geometry_ = std::make_unique<Geometry>(*scene, load_model(*scene, {.shading = false}), box_radius_m);
}

EyeRenderer::~EyeRenderer() = default;

void EyeRenderer::show(std::shared_ptr<const ReceivedFrame> frame, StageTimes& times) {
    const bool is_first = frames_[current_].frame() == nullptr;
    const std::size_t next = is_first ? current_ : 1 - current_;
    frames_[next].upload(std::move(frame));
    current_ = next;
    if (geometry_ != nullptr)
        geometry_->set_time(current().frame()->main.info.time_s);
    times.mark(RenderStage::upload);
}

void EyeRenderer::show_pq_by(std::shared_ptr<PqDisplay> display) {
    pq_display_ = std::move(display);
    for (FrameTextures& frame : frames_)
        frame.show_pq_by(pq_display_);
}

void EyeRenderer::set_exposure(double stops) {
    if (pq_display_ == nullptr)
        return;
    pq_display_->set_exposure(stops);
    for (FrameTextures& frame : frames_)
        frame.show_again();
}

const FrameTextures* EyeRenderer::earlier() const {
    const FrameTextures& other = frames_[1 - current_];
    if (other.frame() == nullptr)
        return nullptr;
    const double before_s = frame().main.info.time_s - other.frame()->main.info.time_s;
    return before_s > 0 && before_s <= longest_memory_s ? &other : nullptr;
}

EyeDepth EyeRenderer::depth() const {
    return by_depth_ ? EyeDepth{geometry_->pass.texture(), DepthPass::inverse_scale()} : EyeDepth{};
}

void EyeRenderer::find_depth() {
    UploadedPicture& main = current().main();
    std::vector<DepthViewpoint>& views = geometry_->views;
    views.clear();
    for (const EyeView& eye : eyes_)
        views.push_back({eye.camera, eye.pose});
    const auto* sphere = std::get_if<EquirectCamera>(&main.view.camera);
    const SphereViews around = sphere != nullptr
                                   ? sphere_views(*sphere, main.view.pose, eyes_)
                                   : flat_source_views(std::get<PerspectiveCamera>(main.view.camera), main.view.pose);
    views.insert(views.end(), around.views.begin(), around.views.end());
    geometry_->pass.draw(views);
    main.textures.forget_depth();
    geometry_->sphere_depth.resolve(geometry_->pass, int(eyes_.size()), around, main.view.pose, main.textures);
}

void EyeRenderer::look(std::span<const EyeView> eyes, bool by_depth, StageTimes& times) {
    assert(!eyes.empty() && current().frame() != nullptr);
    eyes_.assign(eyes.begin(), eyes.end());
    by_depth_ = by_depth && has_depth();
    if (by_depth_)
        find_depth();
    times.mark(RenderStage::depth);
}

void EyeRenderer::fill(const EyeDepth& depth, const EyeTargets& targets) {
    gaps_.find(targets);
    if (depth.texture != 0) {
        const GapTargets to{eyes_, depth, gaps_, targets};
        if (const UploadedPicture* hidden = current().hidden(); hidden != nullptr && hidden->textures.depth() != 0)
            gap_look_up_.fill({hidden->view, hidden->textures, PixelOrigin::hidden}, to);
        if (current().patches() != nullptr)
            patch_look_up_.fill(current().patches_view(), *current().patches(), to);
        if (const FrameTextures* earlier = this->earlier(); earlier != nullptr && earlier->main().textures.depth() != 0)
            gap_look_up_.fill({earlier->main().view, earlier->main().textures, PixelOrigin::earlier}, to);
        gaps_.find(targets);
    }
    push_pull_.fill(current().main().view, eyes_, depth, gaps_, targets);
}

void EyeRenderer::draw(const RefreshOptions& options, EyeTargets& targets, StageTimes& times) {
    targets.size_for(eyes_.front().camera, int(eyes_.size()));
    const UploadedPicture& main = current().main();
    const EyeDepth known = options.surface ? depth() : EyeDepth{};
    (known.texture != 0 ? surface_ : turn_).reproject(main.view, main.textures, eyes_, known, targets);
    times.mark(RenderStage::reproject);
    if (options.fill)
        fill(known, targets);
    times.mark(RenderStage::fill);
    if (options.reliability) {
        reliability_.upload(main.view);
        reliability_.estimate(main.view, main.textures, {eyes_, known, targets},
                              {.coding_loss = coding_loss_of(frame().main.info)});
    }
    times.mark(RenderStage::judge);
}

}  // namespace equistream::gl
