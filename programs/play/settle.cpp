/// FramePlayer's choice by time: frames are played as they would be, each way after the same frame.
#include "frame_player.h"

#include <client/stages/stages.h>

#include <algorithm>
#include <ranges>
#include <utility>

namespace equistream::play {

namespace {

/// Passes look points up by depth that is cast where none came.
const TrackRoles depth_roles =
    TrackRoles().set(std::size_t(TrackRole::hidden_depth)).set(std::size_t(TrackRole::patches_depth));

/// What of a source came with a frame.
TrackRoles roles_of(const ReceivedFrame& frame) {
    TrackRoles roles;
    const auto add = [&](TrackRole role, bool came) { roles[std::size_t(role)] = came; };
    const auto came = [](const std::optional<ReceivedPicture>& picture) { return picture.has_value(); };
    const auto came_with_depth = [](const std::optional<ReceivedPicture>& picture) {
        return picture && !picture->depth_m.empty();
    };
    add(TrackRole::main, true);
    add(TrackRole::window, came(frame.base));
    add(TrackRole::small, came(frame.small));
    add(TrackRole::depth, !frame.main.depth_m.empty());
    add(TrackRole::hidden, came(frame.hidden));
    add(TrackRole::hidden_depth, came_with_depth(frame.hidden));
    add(TrackRole::patches, came(frame.patches));
    add(TrackRole::patches_depth, came_with_depth(frame.patches));
    add(TrackRole::reflections, !frame.main.specular.empty() || !frame.main.virtual_depth_m.empty());
    return roles;
}

}  // namespace

void FramePlayer::settle(const ReceivedFrame& first, const ReceivedFrame* second, Report& report) {
    report.fill = settings_.fill;
    if (settings_.method != "auto")
        return;
    const bool offers_planes = !first.main.depth_m.empty() && !is_cast(settings_.depth);
    if (offers_planes)
        pipeline_.offer_planes();
    gives_depth_ = gives_depth_ || offers_planes;
    const TrackRoles came = roles_of(first) | (second != nullptr ? roles_of(*second) : TrackRoles{});
    // A frame whose depth is lost is only turned, which takes less time than others do.
    const bool times_second = second != nullptr && !(offers_planes && second->main.depth_m.empty());
    const ReceivedFrame& timed = times_second ? *second : first;
    const int repeat = std::exchange(settings_.repeat, 3);
    const auto try_plan = [&](const Plan& plan) { return measure(plan, times_second ? &first : nullptr, timed); };
    const std::vector<Plan> plans = plans_by_accuracy({.geometry = scene_.has_value(),
                                                       .cast = is_drawn(settings_.depth) ? settings_.depth : "ray",
                                                       .streamed_depth = pipeline_.hands_out_planes(),
                                                       .poses = first.posed,
                                                       .fill = settings_.fill,
                                                       .idle_passes = idle_passes(came),
                                                       .mirrors = settings_.asks_for_mirrors()});
    report.choice = choose_plan(plans, settings_.budget_ms, try_plan);
    report.choice->frame = timed.main.info.index;
    const Plan plan = report.choice->plan();
    if (settings_.rechoose && second != nullptr)
        rechooser_.emplace(plans_after(plans, plan, came), *report.choice);
    settings_.repeat = repeat;
    use(plan);
    pipeline_.forget();
    uncounted_ = {};
    report.method = plan.method;
    report.depth = plan.depth;
    if (!is_drawn(plan.depth))
        report.gl_driver.clear();
    report.fill = plan.fill;
}

Trial FramePlayer::measure(const Plan& plan, const ReceivedFrame* before, const ReceivedFrame& timed) {
    use(plan);
    begin_after(before);
    uncounted_ = unneeded_roles(plan.choice());
    PlayedFrame played;
    play(timed, played);
    // The first round warms up; of the others the slower one counts.
    Trial trial{.milliseconds = std::ranges::max(played.times | std::views::drop(1), {}, &FrameTimes::all),
                .filled = played.figures.left.filled};
    for (std::size_t i = 0; i < trial.filled.size(); ++i)
        trial.filled[i].second += played.figures.right.filled[i].second;
    // The first pictures are decoded while scenes load, or begin with a whole one: of two the faster one is like more.
    if (before != nullptr) {
        const auto main_ms = [](const ReceivedFrame& frame) { return frame.main.decode_ms + frame.main.convert_ms; };
        const auto all_ms = [&](const ReceivedFrame& frame) {
            const auto [decode_ms, convert_ms] = decoding_ms(frame);
            return decode_ms + convert_ms;
        };
        trial.milliseconds.all -= std::max(all_ms(timed) - all_ms(*before), 0.0);
        trial.milliseconds.unfilled -= std::max(main_ms(timed) - main_ms(*before), 0.0);
    }
    return trial;
}

std::vector<std::string> FramePlayer::idle_passes(TrackRoles came) const {
    std::vector<std::string> idle;
    for (const FillStage& stage : fill_stages()) {
        const TrackRoles colours = stage.reads & ~depth_roles;
        if ((colours & ~came).any() || (stage.name == "geometry" && !pipeline_.has_geometry_colour()))
            idle.emplace_back(stage.name);
    }
    return idle;
}

void FramePlayer::rechoose(const PlayedFrame& played, std::int64_t next, Report& report) {
    if (!rechooser_ || played.times.empty() || lacks_depth_)
        return;
    const std::optional<Change> change = rechooser_->played(played.times.back(), next);
    if (!change)
        return;
    const std::string before = plan_.fill;
    use(change->to);
    pipeline_.take_over(before);
    report.changes.push_back(*change);
}

void FramePlayer::begin_after(const ReceivedFrame* before) {
    pipeline_.forget();
    if (before == nullptr)
        return;
    PlayedFrame played;
    set_eyes(*before, played);
    pipeline_.find_depths(*before, played.left, played.right);
    remember(ReceivedFrame(*before));
}

void FramePlayer::use(const Plan& plan) {
    plan_ = plan;
    pipeline_.use(ways());
}

PipelineWays FramePlayer::ways() const {
    return {.engine = lacks_depth_ ? "rotation" : plan_.method,
            .by_depth = plan_.depth != "none" && !lacks_depth_,
            .by_planes = settings_.method != "auto" || plan_.depth == "stream",
            .fill = plan_.fill,
            .mirrors = settings_.mirrors,
            .reliability = settings_.reliability,
            .gap_masks = !settings_.out_is_video};
}

}  // namespace equistream::play
