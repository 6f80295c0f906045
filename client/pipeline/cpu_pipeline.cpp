#include "cpu_pipeline.h"

#include <client/stages/stages.h>
#include <equistream/elapsed.h>

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <numeric>
#include <utility>

namespace equistream {

namespace {

/// Both at once: what one thread does for an eye, another does for the other meanwhile.
template <typename Work>
void for_both(PipelineEye& left, PipelineEye& right, const Work& work) {
    tbb::parallel_invoke([&] { work(left); }, [&] { work(right); });
}

}  // namespace

CpuPipeline::CpuPipeline() = default;
CpuPipeline::~CpuPipeline() = default;

void CpuPipeline::use(const PipelineWays& ways) {
    ways_ = ways;
    steps_ = std::make_unique<EyeSteps>(ways.engine, ways.engine_options, ways.mirrors);
    right_steps_ = std::make_unique<EyeSteps>(ways.engine, ways.engine_options, ways.mirrors);
    base_engine_ = std::make_unique<BaseEngine>(ways.engine, ways.engine_options);
    std::unique_ptr<FrameFill>& fill = fills_[ways.fill];
    if (!fill)
        fill = std::make_unique<FrameFill>(ways.fill, geometry_.get());
    fill_ = fill.get();
}

void CpuPipeline::use(MadeDepth depth) {
    depth_ = std::move(depth);
}

void CpuPipeline::use(std::unique_ptr<GeometryColour> geometry) {
    geometry_ = std::move(geometry);
}

void CpuPipeline::offer_planes() {
    if (depth_.planes != nullptr)
        return;
    auto planes = std::make_unique<ExactDepth>(std::move(depth_.source));
    depth_.planes = planes.get();
    depth_.source = std::move(planes);
}

void CpuPipeline::remember(std::shared_ptr<const ReceivedPicture> main, std::shared_ptr<const ReceivedPicture> base) {
    fill_->remember(std::move(main), std::move(base), depths_);
}

void CpuPipeline::forget() {
    fill_->forget();
}

void CpuPipeline::take_over(const std::string& fill_before) {
    if (const auto before = fills_.find(fill_before); before != fills_.end())
        fill_->take_over(*before->second);
}

double CpuPipeline::extrapolation_s(const ReceivedFrame& frame, const PipelineEye& left, const PipelineEye& right,
                                    double wanted_s, bool has_scene) const {
    if (!can_extrapolate(frame.main, wanted_s) || !takes_depth())
        return 0;
    for (const PipelineEye* eye : {&left, &right}) {
        const DepthNeeds needs = engine().needs_depth(frame.main.info.camera_pose, eye->pose);
        // Without geometry eyes have depth of the frame's own time alone.
        if (!needs.source || (needs.eye && !has_scene))
            return 0;
    }
    return wanted_s;
}

void CpuPipeline::offer(const ReceivedFrame& frame) {
    const auto add = [&](const ReceivedPicture& picture) {
        if (!picture.depth_m.empty())
            depth_.planes->add(picture.info.camera, picture.info.camera_pose, picture.depth_m.view());
    };
    add(frame.main);
    if (frame.right)
        add(*frame.right);
    if (frame.base)
        add(*frame.base);
    if (frame.small)
        add(*frame.small);
    for (const ReceivedPicture& view : frame.depth_views)
        add(view);
}

void CpuPipeline::set_frame_time(const ReceivedFrame& frame) {
    depth_.source->set_time(frame.main.info.time_s);
    if (takes_planes())
        offer(frame);
}

void CpuPipeline::cast(const Camera& camera, const Pose& pose, FloatImage& depth_m) {
    if (depth_m.width() != width_of(camera) || depth_m.height() != height_of(camera))
        depth_m = FloatImage(width_of(camera), height_of(camera), 1);
    depth_.source->cast(camera, pose, depth_m.view());
}

void CpuPipeline::choose_pictures(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right) {
    for (PipelineEye* eye : {&left, &right})
        eye->takes_right = takes_right(frame, eye == &right, eye->pose);
}

void CpuPipeline::cast_depths(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right, double extrapolation_s,
                              PipelineTimes& times) {
    SourceDepths memory = std::exchange(depths_, {});
    if (!takes_depth()) {
        left.depth_m = right.depth_m = {};
        return;
    }
    const FrameInfo& main = frame.main.info;
    DepthNeeds needs;
    if (extrapolation_s > 0)
        depth_.source->set_time(main.time_s + extrapolation_s);
    for (PipelineEye* eye : {&left, &right}) {
        const FrameInfo& seen = eye->takes_right ? frame.right->info : main;
        const DepthNeeds own = engine().needs_depth(seen.camera_pose, eye->pose);
        if (own.eye)
            cast(eye->camera, eye->pose, eye->depth_m);
        else
            eye->depth_m = {};
        needs = {needs.source || own.source, needs.eye || own.eye};
    }
    if (extrapolation_s > 0)
        set_frame_time(frame);
    if (!needs.any())
        return;
    if (needs.source) {
        cast(main.camera, main.camera_pose, memory.main);
        depths_.main = std::move(memory.main);
        if (frame.right) {
            cast(frame.right->info.camera, frame.right->info.camera_pose, memory.right);
            depths_.right = std::move(memory.right);
        }
    }
    const auto start = Clock::now();
    cast_fill_depths(frame, memory);
    times.fill_depth = milliseconds_since(start);
}

void CpuPipeline::cast_fill_depths(const ReceivedFrame& frame, SourceDepths& memory) {
    const auto has_depth = [&](const FrameInfo& view) {
        return depth_.planes == nullptr || depth_.casts_any_view || depth_.planes->holds(view.camera, view.camera_pose);
    };
    if (frame.base && fill_->has("base") && has_depth(frame.base->info)) {
        cast(frame.base->info.camera, frame.base->info.camera_pose, memory.base);
        depths_.base = std::move(memory.base);
    }
    if (frame.small && fill_->takes_small() && has_depth(frame.small->info)) {
        cast(frame.small->info.camera, frame.small->info.camera_pose, memory.small);
        depths_.small = std::move(memory.small);
    }
    if (frame.patches && fill_->has("patches")) {
        cast_patches(*frame.patches, memory.patches);
        depths_.patches = std::move(memory.patches);
    }
}

void CpuPipeline::cast_patches(const ReceivedPicture& patches, FloatImage& depth_m) {
    const auto& atlas = patches.info.patches;
    if (!patches.depth_m.empty() || !atlas || patch_atlas_problem(*atlas)) {
        depth_m = {};
        return;
    }
    if (depth_m.width() != atlas->width() || depth_m.height() != atlas->height())
        depth_m = FloatImage(atlas->width(), atlas->height(), 1);
    if (depth_.source->cast_patches(*atlas, patches.info.camera_pose, depth_m.view()))
        return;
    depth_m = {};
    missed_patch_depth_ = !depth_.driver.empty() && !takes_planes();
}

void CpuPipeline::find_depths(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right) {
    require_tagged_sizes(frame);
    choose_pictures(frame, left, right);
    PipelineTimes ignored;
    if (takes_depth())
        set_frame_time(frame);
    cast_depths(frame, left, right, 0, ignored);
}

void CpuPipeline::reproject(const ReceivedFrame& frame, const SourceView& source, PipelineEye& left,
                            PipelineEye& right) {
    steps_->set_source(source);
    if (frame.right)
        right_steps_->set_source(source_view(*frame.right, depths_.right));
    for_both(left, right, [&](PipelineEye& eye) {
        eye.figures = {};
        eye.figures.specular = steps_of(eye).reproject(eye.view(), eye.picture);
    });
}

void CpuPipeline::fill_gaps_of(const ReceivedFrame& frame, const SourceView& source, PipelineEye& left,
                               PipelineEye& right, double shown_s) {
    fill_->set_frame(frame, depths_, {source, shown_s, base_engine_.get()});
    for_both(left, right, [&](PipelineEye& eye) { eye.figures.filled = fill_->fill(eye.view(), eye.picture); });
}

void CpuPipeline::judge(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right) {
    const ReliabilityOptions known = confidence_options(frame.main.info, takes_planes(), ways_.mirrors);
    for (PipelineEye* eye : {&left, &right}) {
        steps_of(*eye).judge(eye->view(), eye->picture, known);
        const auto samples = eye->picture.reliability.samples();
        eye->figures.reliability =
            std::accumulate(samples.begin(), samples.end(), 0.0) / (255.0 * double(samples.size()));
    }
}

void CpuPipeline::render(const ReceivedFrame& frame, PipelineEye& left, PipelineEye& right, double extrapolation_s,
                         PipelineTimes& times) {
    require_tagged_sizes(frame);
    choose_pictures(frame, left, right);
    times = {};
    auto start = Clock::now();
    if (takes_depth() && !(extrapolation_s > 0))
        set_frame_time(frame);
    cast_depths(frame, left, right, extrapolation_s, times);
    if (extrapolation_s > 0)
        extrapolator_.extrapolate(frame.main, depths_.main, extrapolation_s, extrapolated_);
    else
        extrapolated_.moved_pixels = extrapolated_.uncovered_pixels = 0;
    if (takes_depth())
        times.depth = milliseconds_since(start);
    start = Clock::now();
    const SourceView source = extrapolation_s > 0 ? source_view(extrapolated_.picture, extrapolated_.depth_m)
                                                  : source_view(frame.main, depths_.main);
    reproject(frame, source, left, right);
    times.reproject = milliseconds_since(start);
    for_both(left, right, [&](PipelineEye& eye) {
        if (ways_.gap_masks)
            find_gap_mask(eye.picture, eye.gaps);
        eye.figures.pixels = std::int64_t(eye.picture.origin.samples().size());
        eye.figures.gaps = eye.picture.count(PixelOrigin::gap);
    });
    start = Clock::now();
    fill_gaps_of(frame, source, left, right, frame.main.info.time_s + extrapolation_s);
    times.fill = milliseconds_since(start);
    if (!ways_.reliability)
        return;
    start = Clock::now();
    judge(frame, left, right);
    times.reliability = milliseconds_since(start);
}

void find_gap_mask(const EyePicture& picture, ByteImage& mask) {
    if (mask.width() != picture.origin.width() || mask.height() != picture.origin.height())
        mask = ByteImage(picture.origin.width(), picture.origin.height(), 1);
    std::ranges::transform(picture.origin.samples(), mask.samples().begin(), [](std::uint8_t origin) {
        return origin == std::uint8_t(PixelOrigin::gap) ? std::uint8_t{255} : std::uint8_t{0};
    });
}

}  // namespace equistream
