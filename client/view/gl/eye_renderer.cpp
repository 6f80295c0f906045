#include "eye_renderer.h"

#include <equistream/bound.h>

#include <client/pipeline/decisions.h>
#include <client/stages/stages.h>

#include <algorithm>
#include <cassert>
#include <variant>

namespace equistream::gl {

namespace {

ResampleRule rule_of(const EyeDepthFinder* finder) {
    return finder == nullptr || finder->traits().only_seen ? ResampleRule::seen : ResampleRule::any;
}

}  // namespace

/// The client's own geometry, where it is at the time of the frame that is shown.
struct EyeRenderer::Geometry {
    Geometry(const SceneDescription& description, const SceneModel& loaded, double box_radius_m)
        : instances(loaded, description), pass(loaded),
          sphere_depth(box_radius_m, default_budget_share * error_budget_rad(default_focal_length_px)) {}

    void set_time(double time_s) {
        if (instances.any_moves())
            pass.set_transforms(instances.at(time_s));
    }

    /// Of all of its samples, as of the time that was set; without what eyes saw last, which is theirs to keep.
    void draw_whole(UploadedPicture& picture) {
        const Camera& camera = picture.view.camera;
        const Pose& pose = picture.view.pose;
        const auto* sphere = std::get_if<EquirectCamera>(&camera);
        const SphereViews around = sphere != nullptr ? cube_views(*sphere, pose)
                                                     : flat_source_views(std::get<PerspectiveCamera>(camera), pose);
        pass.draw({around.views.data(), around.views.size()}, Culling::outside);
        picture.textures.forget_depth();
        sphere_depth.resolve(pass, 0, around, pose, picture.textures);
    }

    MovedInstances instances;
    DepthPass pass;
    SphereDepth sphere_depth;
    std::vector<DepthViewpoint> views;
    // Of the frame, of its own time:
    bool has_whole_depth = false;   ///< of all of its samples
    bool has_depth_beside = false;  ///< of the pictures beside it
};

EyeRenderer::EyeRenderer(const SceneDescription* scene, double box_radius_m, const std::string& fill,
                         std::string_view finding_engine)
    : finder_(scene == nullptr ? make_finder(finding_engine) : nullptr), engine_(finding_engine),
      turn_(ResampleRule::direction, default_error_budget_px),
      surface_(rule_of(finder_ == nullptr ? nullptr : finder_->engine.get()),
               finder_ == nullptr ? default_error_budget_px : finder_->engine->traits().error_budget_px),
      chain_(make_gl_fill_chain(fill, fill_shared_)) {
    if (scene != nullptr)
        geometry_ = std::make_unique<Geometry>(*scene, load_model(*scene, {.shading = false}), box_radius_m);
}

std::unique_ptr<EyeRenderer::Finder> EyeRenderer::make_finder(std::string_view engine) {
    auto found = make_eye_depth_from_source(engine);
    // Clang 14 makes no aggregate of arguments in brackets.
    return found == nullptr ? nullptr : std::unique_ptr<Finder>(new Finder{std::move(found), {}});
}

EyeRenderer::~EyeRenderer() = default;

void EyeRenderer::show(std::shared_ptr<const ReceivedFrame> frame, StageTimes& times) {
    const bool is_first = frames_[current_].frame() == nullptr;
    const std::size_t next = is_first ? current_ : 1 - current_;
    require_tagged_sizes(*frame);  // before a window goes for it
    leave_window(next);
    frames_[next].upload(std::move(frame));
    specular_[next].upload(frames_[next].main().view);
    if (finder_ != nullptr && base_engine_ == nullptr && frames_[next].base() != nullptr &&
        fills_from(TrackRole::window))
        base_engine_ = make_eye_depth_from_source(engine_);
    current_ = next;
    extrapolation_s_ = 0;
    find_left_windows();
    if (geometry_ != nullptr) {
        geometry_->has_whole_depth = geometry_->has_depth_beside = false;
        geometry_->set_time(this->frame().main.info.time_s);
    } else if (finder_ != nullptr) {
        finder_->engine->forget_source();
        if (base_engine_ != nullptr)
            base_engine_->forget_source();
        if (frames_[next].right() != nullptr && this->frame().posed && right_engine_ == nullptr)
            right_engine_ = make_eye_depth_from_source(engine_);
        if (right_engine_ != nullptr)
            right_engine_->forget_source();
    }
    extrapolator_.set_picture(this->frame().main.info);
    times.mark(RenderStage::upload);
}

void EyeRenderer::leave_window(std::size_t place) {
    left_pictures_.clear();  // of windows that may go
    FrameTextures& frame = frames_[place];
    const bool has_window = frame.frame() != nullptr && frame.base() != nullptr && frame.main().textures.depth() != 0;
    if (!has_window || !std::ranges::any_of(chain_, [](const auto& pass) { return pass->name() == "earlier"; }))
        return;
    LeftTextures left = spare_ ? *std::exchange(spare_, std::nullopt) : LeftTextures();
    frame.trade_window(left);
    std::swap(left.specular, specular_[place]);
    for (UploadedPicture* picture : {&left.window, &left.base})
        picture->textures.show_pq_by(pq_display_);
    spare_ = left_windows_.leave(std::move(left));
}

/// Once a frame: which of them there are changes with it alone.
void EyeRenderer::find_left_windows() {
    const FrameInfo& main = frame().main.info;
    if (current().base() == nullptr)
        return;
    left_windows_.each_beside(main.camera, main.time_s, [&](const LeftTextures& left) {
        const UploadedPicture &window = left.window, &base = left.base;
        left_pictures_.push_back({{window.view, window.textures, PixelOrigin::earlier},
                                  {base.view, base.textures, PixelOrigin::base},
                                  {window.view, window.textures, left.specular}});
    });
}

bool EyeRenderer::frame_has_depth() const {
    return frame().posed && !frame().main.depth_m.empty();
}

bool EyeRenderer::has_depth() const {
    if (frames_[current_].frame() == nullptr || !frame().posed)
        return false;
    return has_geometry() || (finder_ != nullptr && (!finder_->engine->traits().needs_depth || frame_has_depth()));
}

bool EyeRenderer::can_extrapolate() const {
    const bool moves = geometry_ != nullptr ? geometry_->instances.any_moves() : frame_has_depth();
    return moves && !frame().main.info.moving.empty();
}

void EyeRenderer::read_in_place(const std::shared_ptr<PictureBuffers>& buffers) {
    for (FrameTextures& frame : frames_)
        frame.read_in_place(buffers);
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
    left_windows_.each([](LeftTextures& left) {
        left.window.textures.show_again();
        left.base.textures.show_again();
    });
    if (current().frame() != nullptr)
        extrapolator_.set_picture(frame().main.info);
}

const FrameTextures* EyeRenderer::earlier() const {
    const FrameTextures& other = frames_[1 - current_];
    if (other.frame() == nullptr)
        return nullptr;
    return counts_as_earlier(other.frame()->main.info.time_s, frame().main.info.time_s) ? &other : nullptr;
}

EyeDepth EyeRenderer::depth() const {
    return finder_ == nullptr || finder_->engine->traits().is_known ? eyes_depth() : EyeDepth{};
}

EyeDepth EyeRenderer::eyes_depth() const {
    if (!by_depth_)
        return {};
    if (by_eye_ && geometry_ == nullptr)
        return {by_eye_depth_.name(), 1};
    return geometry_ != nullptr ? EyeDepth{geometry_->pass.texture(), DepthPass::inverse_scale(), GL_DEPTH_COMPONENT}
                                : finder_->engine->depth();
}

bool EyeRenderer::fills_from(TrackRole role) const {
    return std::ranges::any_of(chain_,
                               [&](const auto& pass) { return find_fill(pass->name()).reads[std::size_t(role)]; });
}

std::array<UploadedPicture*, 3> EyeRenderer::looked_up_beside() {
    return {fills_from(TrackRole::small) ? current().small() : nullptr,
            fills_from(TrackRole::window) ? current().base() : nullptr, by_eye_ ? current().right() : nullptr};
}

bool EyeRenderer::needs_depth_beside() {
    return !geometry_->has_depth_beside &&
           std::ranges::any_of(looked_up_beside(), [](const auto* picture) { return picture != nullptr; });
}

/// Once a frame, of all samples: there are few.
void EyeRenderer::find_depth_beside() {
    for (UploadedPicture* picture : looked_up_beside())
        if (picture != nullptr)
            geometry_->draw_whole(*picture);
    geometry_->has_depth_beside = true;
}

void EyeRenderer::find_depth() {
    UploadedPicture& main = current().main();
    if (finder_ != nullptr && by_eye_)
        return;  // found as each eye is drawn
    if (finder_ != nullptr) {
        // Depth that is extrapolated is another at each refresh.
        if (finder_->engine->traits().needs_depth && (is_extrapolated_ || finder_->knows_extrapolated))
            finder_->engine->forget_source();
        finder_->knows_extrapolated = is_extrapolated_;
        finder_->engine->find(main.view, resampled(), eyes_);
        return;
    }
    if (needs_depth_beside())
        find_depth_beside();
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

/// The source's as of the frame's own time, once a frame and everywhere, for things come from where no eye looks; the
/// eyes' as of later.
void EyeRenderer::find_depths_apart() {
    const double frame_s = frame().main.info.time_s;
    if (!geometry_->has_whole_depth || needs_depth_beside())
        geometry_->set_time(frame_s);
    if (needs_depth_beside())
        find_depth_beside();
    if (!geometry_->has_whole_depth) {
        geometry_->draw_whole(current().main());
        geometry_->has_whole_depth = true;
    }
    geometry_->set_time(frame_s + extrapolated_s());
    std::vector<DepthViewpoint>& views = geometry_->views;
    views.clear();
    for (const EyeView& eye : eyes_)
        views.push_back({eye.camera, eye.pose});
    geometry_->pass.draw(views);
}

const SourceTextures& EyeRenderer::resampled() const {
    return is_extrapolated_ ? extrapolator_.extrapolated() : source();
}

void EyeRenderer::look(std::span<const EyeView> eyes, bool by_depth, StageTimes& times) {
    assert(!eyes.empty() && current().frame() != nullptr);
    eyes_.assign(eyes.begin(), eyes.end());
    by_depth_ = by_depth && has_depth();
    has_motion_ = false;
    const UploadedPicture* const right = current().right();
    by_eye_ = by_depth_ && right != nullptr &&
              (geometry_ != nullptr || !finder_->engine->traits().needs_depth || right->textures.depth() != 0);
    // An eye at the source's place looks up all that it shows, and would see what has moved twice.
    const Pose& source_pose = frame().main.info.camera_pose;
    is_extrapolated_ =
        by_depth_ && can_extrapolate() && extrapolation_s_ > 0 &&
        std::ranges::none_of(eyes, [&](const EyeView& eye) { return same_position(source_pose, eye.pose); });
    // Depth from everywhere is kept for as long as there is some: what comes next may be extrapolated again.
    const bool apart = geometry_ != nullptr && (is_extrapolated_ || (by_depth_ && geometry_->has_whole_depth));
    if (apart)
        find_depths_apart();
    times.mark(RenderStage::depth);
    if (is_extrapolated_)
        extrapolator_.extrapolate(source(), specular_[current_], extrapolation_s_);
    times.mark(RenderStage::extrapolate);
    if (by_depth_ && !apart)
        find_depth();
    times.mark(RenderStage::depth);
}

SpecularSource EyeRenderer::mirroring() {
    return {current().main().view, resampled(),
            is_extrapolated_ ? extrapolator_.extrapolated_specular() : specular_[current_]};
}

GlFillFrame EyeRenderer::fill_frame(bool by_surface) {
    const auto picture = [](const UploadedPicture* other, PixelOrigin mark) -> std::optional<OtherPicture> {
        if (other == nullptr)
            return std::nullopt;
        return OtherPicture{other->view, other->textures, mark};
    };
    const FrameTextures* before = earlier();
    GlFillFrame from{.main = {current().main().view, resampled()},
                     .base = picture(current().base(), PixelOrigin::base),
                     .hidden = picture(current().hidden(), PixelOrigin::hidden),
                     .small = picture(current().small(), PixelOrigin::small),
                     .earlier = picture(before != nullptr ? &before->main() : nullptr, PixelOrigin::earlier),
                     .left = left_pictures_,
                     .see_base = [this, by_surface] { return see_base(by_surface); },
                     .found = finder_ != nullptr ? &finder_->gaps : nullptr,
                     .mirrors = mirroring(),
                     .mirrors_earlier = std::nullopt,
                     .gap_mirrors = &gap_mirrors_};
    if (current().patches() != nullptr) {
        from.patches = &current().patches_view();
        from.patch_textures = current().patches();
    }
    if (before != nullptr)
        from.mirrors_earlier.emplace(
            SpecularSource{before->main().view, before->main().textures, specular_[1 - current_]});
    return from;
}

SeenBase EyeRenderer::see_base(bool by_surface) {
    const UploadedPicture& base = *current().base();
    const bool has_depth = base.textures.depth() != 0;
    base_targets_.size_for(eyes_.front().camera, int(eyes_.size()));
    EyeDepth found;
    if (by_surface && geometry_ != nullptr) {
        found = has_depth ? eyes_depth() : EyeDepth{};
    } else if (by_surface && (has_depth || !base_engine_->traits().needs_depth)) {
        // What it was to find at the last refresh may have been left out on the GPU.
        if (base_engine_->traits().needs_depth)
            base_engine_->forget_source();
        base_engine_->find(base.view, base.textures, eyes_);
        found = base_engine_->depth();
    }
    (found.texture != 0 ? surface_ : turn_).reproject(base.view, base.textures, eyes_, found, base_targets_);
    const bool is_known = geometry_ != nullptr || (base_engine_ != nullptr && base_engine_->traits().is_known);
    return {base_targets_, is_known ? found : EyeDepth{}};
}

void EyeRenderer::fill(const EyeDepth& depth, bool by_surface, const EyeTargets& targets) {
    const GlFillFrame from = fill_frame(by_surface);
    for (const auto& pass : chain_) {
        gaps_.find(targets);
        pass->fill(from, {eyes_, depth, gaps_, targets});
    }
}

namespace {

void copy_layer(GLuint from, int from_layer, GLuint to, int to_layer, Size size) {
    glCopyImageSubData(from, GL_TEXTURE_2D_ARRAY, 0, 0, 0, from_layer, to, GL_TEXTURE_2D_ARRAY, 0, 0, 0, to_layer,
                       size.width, size.height, 1);
}

}  // namespace

bool EyeRenderer::takes_right(std::size_t eye, bool right_alone) const {
    return equistream::takes_right(frame(), eyes_.size() == 1 ? right_alone : eye == 1, eyes_[eye].pose);
}

void EyeRenderer::copy_eye(std::size_t eye, EyeTargets& targets) {
    copy_layer(one_eye_.colour(), 0, targets.colour(), int(eye), targets.size());
    copy_layer(one_eye_.origin(), 0, targets.origin(), int(eye), targets.size());
}

void EyeRenderer::turn_apart(bool right_alone, EyeTargets& targets) {
    one_eye_.size_for(eyes_.front().camera, 1);
    for (std::size_t i = 0; i < eyes_.size(); ++i) {
        const UploadedPicture& own = takes_right(i, right_alone) ? *current().right() : current().main();
        turn_.reproject(own.view, own.textures, {&eyes_[i], 1}, {}, one_eye_);
        copy_eye(i, targets);
    }
}

void EyeRenderer::reproject_by_eye(EyeTargets& targets) {
    const Size size = targets.size();
    const int eyes = int(eyes_.size());
    one_eye_.size_for(eyes_.front().camera, 1);
    if (size != by_eye_size_ || eyes != by_eye_count_) {
        if (geometry_ != nullptr)
            one_depth_ = make_layered_texture(size, 1, GL_DEPTH_COMPONENT32F);
        else
            by_eye_depth_ = make_layered_texture(size, eyes, GL_R32F);
        by_eye_size_ = size;
        by_eye_count_ = eyes;
    }
    for (int i = 0; i < eyes; ++i) {
        const std::span<const EyeView> eye(&eyes_[std::size_t(i)], 1);
        const bool is_right = takes_right(std::size_t(i), false);
        const UploadedPicture& own = is_right ? *current().right() : current().main();
        if (geometry_ != nullptr) {
            EyeDepth depth = eyes_depth();
            copy_layer(depth.texture, i, one_depth_.name(), 0, size);
            depth.texture = one_depth_.name();
            surface_.reproject(own.view, own.textures, eye, depth, one_eye_);
        } else {
            EyeDepthFinder& engine = is_right ? *right_engine_ : *finder_->engine;
            engine.find(own.view, own.textures, eye);
            surface_.reproject(own.view, own.textures, eye, engine.depth(), one_eye_);
            engine.forget_gaps(one_eye_);
            glMemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);
            copy_layer(engine.depth().texture, 0, by_eye_depth_.name(), i, size);
        }
        copy_eye(std::size_t(i), targets);
    }
}

void EyeRenderer::draw(const RefreshOptions& options, EyeTargets& targets, StageTimes& times) {
    targets.size_for(eyes_.front().camera, int(eyes_.size()));
    const UploadedPicture& main = current().main();
    if (options.surface && by_eye_)
        reproject_by_eye(targets);
    else if (options.surface && eyes_depth().texture != 0)
        surface_.reproject(main.view, resampled(), eyes_, eyes_depth(), targets);
    else if (current().right() != nullptr)
        turn_apart(options.right_alone, targets);
    else
        turn_.reproject(main.view, main.textures, eyes_, {}, targets);
    const EyeDepth known = options.surface ? depth() : EyeDepth{};
    const EyeDepth found = options.surface ? eyes_depth() : EyeDepth{};
    mirrors_.rework(mirroring(), eyes_, known, targets, options.mirrors);
    if (known.texture != 0 && finder_ != nullptr && !by_eye_)
        finder_->engine->forget_gaps(targets);
    times.mark(RenderStage::reproject);
    if (options.fill)
        fill(known, found.texture != 0, targets);
    times.mark(RenderStage::fill);
    if (options.reliability) {
        const bool is_found = known.texture != 0 && finder_ != nullptr;
        JudgedEyes judged{eyes_, known, targets};
        const bool of_main_alone = options.surface && !by_eye_ && found.texture != 0;
        for (std::size_t i = 0; current().right() != nullptr && !of_main_alone && i < eyes_.size(); ++i)
            if (takes_right(i, options.right_alone && !(options.surface && by_eye_)))
                judged.sources[i] = &current().right()->view;
        reliability_.estimate(mirroring(), judged, confidence_options(frame().main.info, is_found, options.mirrors));
    }
    if (options.motion && !frame().main.info.moving.empty()) {
        has_motion_ = true;
        if (!is_extrapolated_)
            extrapolator_.rest();
        motion_.find(main.view, extrapolator_, eyes_, known);
    }
    times.mark(RenderStage::judge);
}

void StageTimes::start(bool told_apart) {
    told_apart_ = told_apart;
    row_ = {};
    if (told_apart_)
        glFinish();
    last_ = Clock::now();
}

void StageTimes::mark(RenderStage stage) {
    if (!told_apart_)
        return;
    glFinish();
    row_[std::size_t(stage)] += milliseconds_since(last_);
    last_ = Clock::now();
}

}  // namespace equistream::gl
