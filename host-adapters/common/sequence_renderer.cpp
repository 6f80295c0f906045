#include "sequence_renderer.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>

#include <cstdio>

namespace equistream::render_command {

SequenceRenderer::SequenceRenderer(const SequenceJob& job, RenderHost& host, RenderReport& report)
    : job_(job), host_(host), report_(report),
      progress_("render", static_cast<double>(count_paths()), job.options.progress) {}

void SequenceRenderer::run() {
    if (report_.frames_kept > 0)
        std::fprintf(stderr, "equistream render: %lld of %lld frames are finished and kept\n",
                     static_cast<long long>(report_.frames_kept), static_cast<long long>(frames_in_all()));
    const auto start = Clock::now();
    for (std::int64_t index = job_.timeline.range.first; index <= job_.timeline.range.last; ++index) {
        require_uninterrupted();
        render_index(index);
    }
    start_writing();
    finish_writing();
    report_.render_s = seconds_since(start);
    report_.paths = paths_;
}

std::int64_t SequenceRenderer::frames_in_all() const {
    return (job_.timeline.range.last - job_.timeline.range.first + 1) * static_cast<std::int64_t>(job_.streams.size());
}

std::uint64_t SequenceRenderer::count_paths() {
    std::uint64_t paths = 0;
    for (std::int64_t index = job_.timeline.range.first; index <= job_.timeline.range.last; ++index) {
        require_uninterrupted();
        for (const Stream& stream : job_.streams)
            if (es_sequence_has_frame(stream.sequence.get(), index))
                ++report_.frames_kept;
            else if (stream.settings.layer == ES_LAYER_FIRST && !stream.settings.patches)
                // how little of the others there is shows when they are rendered
                paths += stream.settings.pixels() * job_.options.spp;
    }
    return paths;
}

void SequenceRenderer::require_uninterrupted() const {
    if (job_.interrupted)
        throw WorkError("interrupted: " + std::to_string(report_.frames_rendered + report_.frames_kept) + " of " +
                        std::to_string(frames_in_all()) + " frames are finished; the same command goes on there");
}

void SequenceRenderer::render_index(std::int64_t index) {
    bool moved = false;
    for (const Stream& stream : job_.streams) {
        if (es_sequence_has_frame(stream.sequence.get(), index))
            continue;
        if (!std::exchange(moved, true))
            host_.move_to(job_.timeline.times(index));
        render_frame(stream, index);
    }
}

void SequenceRenderer::render_frame(const Stream& stream, std::int64_t index) {
    FrameTask task;
    task.stream = &stream.settings;
    task.index = index;
    const FrameTimes times = job_.timeline.times(index);
    task.head_previous = job_.timeline.path.at(times.previous_s);
    task.head = job_.timeline.path.at(times.now_s);
    task.head_next = job_.timeline.path.at(times.next_s);
    task.stop = &job_.interrupted;
    task.paths_traced = [this](std::uint64_t paths) { progress_.set(static_cast<double>(paths_ += paths)); };
    // A sequence serves one thread at a time: this frame begins before the last one's writing does.
    const std::vector<PatchAtlas::Slot> slots = plan(stream, task);
    FramePointer frame = begin_frame(stream, task, {times.now_s, slots});
    task.frame = frame.get();
    start_writing();
    host_.render(task);
    finish_writing();
    require_uninterrupted();
    rendered_ = std::move(frame);
    note_ = stream.settings.name + " frame " + std::to_string(index);
}

/// Of a stream of patches: what its slots show in this frame.
std::vector<PatchAtlas::Slot> SequenceRenderer::plan(const Stream& stream, const FrameTask& task) {
    if (!stream.settings.patches)
        return {};
    if (!patches_)
        patches_.emplace(job_.options, job_.head_radius_m);
    const PatchPlan plan = patches_->plan(host_, task);
    ++report_.patches.frames;
    report_.patches.pixel_share += plan.figures.pixel_share;
    report_.patches.covered += plan.figures.covered;
    report_.patches.kept_slots += static_cast<double>(plan.figures.kept_slots);
    report_.patches.used_slots += static_cast<double>(plan.atlas.used_slots());
    report_.patches.plan_s += plan.figures.plan_s + plan.figures.cast_s;
    return plan.atlas.slots;
}

void SequenceRenderer::start_writing() {
    if (rendered_)
        writing_ = std::async(std::launch::async, end_frame, std::move(rendered_));
}

void SequenceRenderer::finish_writing() {
    if (!writing_)
        return;
    std::exchange(writing_, std::nullopt)->get();
    ++report_.frames_rendered;
    progress_.step(static_cast<double>(paths_), note_);
}

}  // namespace equistream::render_command
