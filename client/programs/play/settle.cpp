/// FramePlayer's choice by time: frames are played as they would be, each way after the same frame.
#include "frame_player.h"

#include <algorithm>
#include <utility>

namespace equistream::play {

void FramePlayer::settle(const ReceivedFrame& first, const ReceivedFrame* second, Report& report) {
    report.fill = settings_.fill;
    if (settings_.method != "auto")
        return;
    if (exact_ == nullptr && !first.main.depth_m.empty() && settings_.depth != "ray") {
        auto exact = std::make_unique<ExactDepth>(std::move(depth_));
        exact_ = exact.get();
        depth_ = std::move(exact);
    }
    const ReceivedFrame& timed = second != nullptr ? *second : first;
    const int repeat = std::exchange(settings_.repeat, 3);
    const auto measure = [&](const Plan& plan) {
        use(plan);
        begin_after(second != nullptr ? &first : nullptr);
        PlayedFrame played;
        play(timed, played);
        Trial trial{.filled = played.figures.left.filled};
        for (std::size_t i = 0; i < trial.filled.size(); ++i)
            trial.filled[i].second += played.figures.right.filled[i].second;
        // The first round warms up; of the others the slower one counts.
        for (const std::vector<double>& stage : played.figures.milliseconds)
            if (!stage.empty())
                trial.milliseconds +=
                    *std::max_element(stage.size() > 1 ? stage.begin() + 1 : stage.begin(), stage.end());
        return trial;
    };
    const std::vector<Plan> plans = plans_by_accuracy({.geometry = scene_.has_value(),
                                                       .streamed_depth = exact_ != nullptr,
                                                       .poses = first.posed,
                                                       .fill = settings_.fill});
    report.choice = choose_plan(plans, settings_.budget_ms, measure);
    report.choice->frame = timed.main.info.index;
    settings_.repeat = repeat;
    const Plan& plan = report.choice->tried[report.choice->chosen].plan;
    use(plan);
    forget();
    report.method = plan.method;
    report.depth = plan.depth;
    report.depth_reuse = report.depth_reuse && plan.depth == "ray";
    report.fill = plan.fill;
}

void FramePlayer::begin_after(const ReceivedFrame* before) {
    forget();
    if (before == nullptr)
        return;
    PlayedFrame played;
    played.left.info = eye_info(*before, Eye::left);
    played.right.info = eye_info(*before, Eye::right);
    take_depths(*before, played);
    remember(ReceivedFrame(*before));
}

void FramePlayer::forget() {
    if (ray_ != nullptr)
        ray_->forget();
    fill_->forget();
}

void FramePlayer::use(const Plan& plan) {
    method_ = plan.method;
    engine_ = make_engine(plan.method, {.mesh_share = plan.mesh_share});
    use_fill(plan.fill);
    offers_depth_ = plan.depth == "stream";
}

}  // namespace equistream::play
