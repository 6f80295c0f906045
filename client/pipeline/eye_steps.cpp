#include "eye_steps.h"

#include "decisions.h"

#include <equistream/error.h>
#include <equistream/patches.h>

#include <client/stages/stages.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace equistream {

EyeSteps::EyeSteps(std::string_view engine, const EngineOptions& options, MirrorTreatment mirrors)
    : engine_(make_engine(engine, options)), error_budget_px_(options.error_budget_px), mirrors_(mirrors) {}

void EyeSteps::set_source(const SourceView& source) {
    source_ = source;
    engine_->set_source(source_);
}

SpecularCounts EyeSteps::reproject(const EyeView& eye, EyePicture& picture) const {
    engine_->reproject(eye, picture);
    return rework_specular(source_, eye, picture, {.error_budget_px = error_budget_px_, .treatment = mirrors_});
}

void EyeSteps::judge(const EyeView& eye, EyePicture& picture, const ReliabilityOptions& known) const {
    estimate_reliability(source_, eye, picture, known);
}

namespace {

ImageView<const float> view_of(const FloatImage& image) {
    return image.empty() ? ImageView<const float>{} : image.view();
}

}  // namespace

bool has_pass(const FillChain& chain, std::string_view name) {
    return std::ranges::any_of(chain, [&](const auto& fill_pass) { return fill_pass->name() == name; });
}

FrameFill::FrameFill(const std::string& passes, GeometryColour* geometry)
    : chain_(make_fill_chain(passes)), has_earlier_pass_(has_pass(chain_, "earlier")), geometry_(geometry) {}

FrameFill::~FrameFill() = default;

bool FrameFill::has(std::string_view fill_pass) const {
    return has_pass(chain_, fill_pass);
}

bool FrameFill::takes_small() const {
    return std::ranges::any_of(chain_, [](const auto& fill_pass) {
        return find_fill(fill_pass->name()).reads[std::size_t(TrackRole::small)];
    });
}

bool FrameFill::wants_depth() const {
    return std::ranges::any_of(chain_, [](const auto& fill_pass) { return fill_pass->wants_depth(); });
}

void FrameFill::set_frame(const ReceivedFrame& frame, const SourceDepths& depths, const Shown& shown) {
    main_ = shown.main;
    base_.reset();
    small_.reset();
    hidden_.reset();
    patches_.reset();
    if (frame.base)
        base_ = source_view(*frame.base, depths.base);
    if (base_ && shown.base_engine != nullptr)
        shown.base_engine->set_base(*base_);
    if (frame.small)
        small_ = source_view(*frame.small, depths.small);
    if (frame.hidden)
        hidden_ = source_view(*frame.hidden, frame.hidden->depth_m);
    if (frame.patches && frame.patches->info.patches) {
        const PatchAtlas& atlas = *frame.patches->info.patches;
        if (const auto problem = patch_atlas_problem(atlas))
            throw WorkError("frame " + std::to_string(frame.main.info.index) + ": patches: " + *problem);
        patches_ = {.rgb = frame.patches->rgb.view(),
                    .yuv = frame.patches->yuv.planes,
                    .depth_m = view_of(frame.patches->depth_m.empty() ? depths.patches : frame.patches->depth_m),
                    .atlas = &atlas,
                    .pose = frame.patches->info.camera_pose,
                    .box_radius_m = main_->box_radius_m};
    }
    earlier_views_.clear();
    earlier_bases_.clear();
    if (earlier_ && counts_as_earlier(earlier_->time_s(), frame.main.info.time_s))
        show_earlier(*earlier_, nullptr);
    if (frame.base)
        left_windows_.each_beside(frame.main.info.camera, frame.main.info.time_s,
                                  [&](const Earlier& window) { show_earlier(window, window.base.get()); });
    if (geometry_)
        geometry_->set_time(shown.time_s);
    const auto address = [](const auto& view) { return view ? &*view : nullptr; };
    for (const auto& fill_pass : chain_)
        fill_pass->set_frame({.main = address(main_),
                              .small = address(small_),
                              .base = address(base_),
                              .base_engine = shown.base_engine,
                              .earlier = earlier_views_,
                              .earlier_bases = earlier_bases_,
                              .hidden = address(hidden_),
                              .patches = address(patches_),
                              .geometry = geometry_});
}

void FrameFill::show_earlier(const Earlier& earlier, const ReceivedPicture* base) {
    earlier_views_.push_back(source_view(*earlier.picture, earlier.depth_m));
    earlier_bases_.push_back(base != nullptr ? source_view(*base, {}) : SourceView{});
}

void FrameFill::take_over(FrameFill& before) {
    if (&before == this)
        return;
    if (has_earlier_pass_) {
        earlier_ = std::exchange(before.earlier_, std::nullopt);
        left_windows_ = std::move(before.left_windows_);
    }
    before.forget();
}

/// Where it is a window; gives the memory of what does not stay.
FloatImage FrameFill::leave(Earlier earlier) {
    if (!earlier.base)
        return std::move(earlier.depth_m);
    std::optional<Earlier> outdated = left_windows_.leave(std::move(earlier));
    return outdated ? std::move(outdated->depth_m) : FloatImage();
}

void FrameFill::remember(std::shared_ptr<const ReceivedPicture> main, std::shared_ptr<const ReceivedPicture> base,
                         SourceDepths& depths) {
    const bool is_kept = earlier_ && earlier_->picture == main;  // it was shown once more
    if (!has_earlier_pass_ || depths.main.empty() || is_kept)
        return;
    std::optional<Earlier> before =
        std::exchange(earlier_, Earlier{std::move(main), std::move(base), std::exchange(depths.main, {})});
    if (before)
        depths.main = leave(std::move(*before));
}

}  // namespace equistream
