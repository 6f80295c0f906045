#include "sequence_renderer.h"

#include <equistream/elapsed.h>
#include <equistream/error.h>
#include <equistream/json_text.h>

#include <programs/cli/provenance.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

namespace equistream::render_command {

SequenceRenderer::SequenceRenderer(const SequenceJob& job, RenderHost& host, RenderReport& report)
    : job_(job), host_(host), report_(report),
      windows_(job.options.window ? std::optional<WindowPlaces>(std::in_place, job.options, job.timeline)
                                  : std::nullopt),
      finished_(check_finished()), progress_("render", static_cast<double>(count_paths()), job.options.progress) {
    count_moves();
}

void SequenceRenderer::run() {
    if (report_.frames_kept > 0)
        std::fprintf(stderr, "equistream render: %lld of %lld frames are finished and kept\n",
                     static_cast<long long>(report_.frames_kept), static_cast<long long>(frames_in_all()));
    if (rendered_again_ > 0)
        std::fprintf(stderr,
                     "equistream render: note: --accumulate renders %lld finished frames again: later frames average "
                     "their light\n",
                     static_cast<long long>(rendered_again_));
    if (job_.timeline.range.first > 0 &&
        std::ranges::any_of(job_.streams, [](const Stream& stream) { return stream.settings.accumulates; }))
        std::fprintf(stderr,
                     "equistream render: note: --accumulate begins anew at frame %lld; frames before it are not read\n",
                     static_cast<long long>(job_.timeline.range.first));
    const auto start = Clock::now();
    try {
        for (std::int64_t index = job_.timeline.range.first; index <= job_.timeline.range.last; ++index) {
            stop_if_interrupted();
            render_index(index);
        }
    } catch (const InputError& error) {
        keep_if_finished();
        // Frames are finished, so what was asked for can be done: a file that it needs has changed or is missing.
        if (report_.frames_rendered > 0)
            throw WorkError(error.what());
        throw;
    } catch (...) {
        keep_if_finished();
        throw;
    }
    start_writing();
    finish_writing();
    report_.render_s = seconds_since(start);
    report_.paths = paths_;
}

std::int64_t SequenceRenderer::frames_in_all() const {
    return (job_.timeline.range.last - job_.timeline.range.first + 1) * static_cast<std::int64_t>(job_.streams.size());
}

/// An interrupt ends it early: what was not looked at counts as not finished.
std::vector<std::vector<bool>> SequenceRenderer::check_finished() const {
    const cli::FrameRange& range = job_.timeline.range;
    const auto frames = static_cast<std::size_t>(range.last - range.first + 1);
    std::vector<std::vector<bool>> finished(job_.streams.size(), std::vector<bool>(frames, false));
    cli::Progress progress("checking", static_cast<double>(frames_in_all()), job_.options.progress);
    std::int64_t checked = 0, found = 0;
    for (std::size_t frame = 0; frame < frames && !job_.interrupted; ++frame)
        for (std::size_t stream = 0; stream < finished.size(); ++stream) {
            const std::int64_t index = range.first + static_cast<std::int64_t>(frame);
            const bool is_finished = es_sequence_has_frame(job_.streams[stream].sequence.get(), index) != 0;
            finished[stream][frame] = is_finished;
            progress.set(static_cast<double>(++checked));
            found += is_finished;
        }
    if (found > 0)
        progress.step(static_cast<double>(checked), std::to_string(found) + " frames are finished");
    return finished;
}

bool SequenceRenderer::was_finished(const Stream& stream, std::int64_t index) const {
    const auto place = static_cast<std::size_t>(&stream - job_.streams.data());
    return finished_[place][static_cast<std::size_t>(index - job_.timeline.range.first)];
}

/// Finished, and not needed for what later frames carry on.
bool SequenceRenderer::is_kept(const Stream& stream, std::int64_t index) const {
    return was_finished(stream, index) && (!stream.settings.accumulates || index >= last_missing_);
}

void SequenceRenderer::find_last_missing() {
    for (std::int64_t index = job_.timeline.range.first; index <= job_.timeline.range.last; ++index)
        for (const Stream& stream : job_.streams)
            if (stream.settings.accumulates && !was_finished(stream, index))
                last_missing_ = index;
}

std::uint64_t SequenceRenderer::count_paths() {
    find_last_missing();
    std::uint64_t paths = 0;
    for (std::int64_t index = job_.timeline.range.first; index <= job_.timeline.range.last; ++index)
        for (const Stream& stream : job_.streams) {
            const bool kept = is_kept(stream, index);
            report_.frames_kept += kept;
            rendered_again_ += !kept && was_finished(stream, index);
            if (!kept && stream.settings.layer == ES_LAYER_FIRST && !stream.settings.patches)
                // how little of the others there is shows when they are rendered
                paths += sampled_pixels(stream.settings, index) * job_.options.spp;
        }
    if (job_.interrupted)
        require_all_finished();
    if (job_.options.part.is_put_together())
        return 0;
    return job_.options.part.is_one() ? paths / job_.options.part.count : paths;
}

/// All, but for a base's tiles that the window covers. Frames that are accumulated are sampled everywhere.
std::uint64_t SequenceRenderer::sampled_pixels(const StreamSettings& stream, std::int64_t index) {
    std::uint64_t pixels = stream.pixels();
    if (job_.options.samples_by_angle) {  // in proportion to the cosine of the latitude
        const LongitudeLatitudeRange& range = job_.options.range;
        const double span = std::sin(range.latitude_max) - std::sin(range.latitude_min);
        return static_cast<std::uint64_t>(double(pixels) * span / range.latitude_span());
    }
    if (!stream.is_base || !host_.fills_tiles() || job_.options.accumulate > 0)
        return pixels;
    const WindowCover cover(job_.options.window->grid, windows_->at(index), stream.size.width, stream.size.height);
    for (int y = 0; y < stream.size.height; y += stream.tile_side)
        for (int x = 0; x < stream.size.width; x += stream.tile_side) {
            const int width = std::min(stream.tile_side, stream.size.width - x);
            const int height = std::min(stream.tile_side, stream.size.height - y);
            if (cover.covers(x, y, width, height))
                pixels -= static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
        }
    return pixels;
}

void SequenceRenderer::count_moves() {
    if (!windows_)
        return;
    report_.window = WindowReport{job_.options.window->grid};
    for (std::int64_t index = job_.timeline.range.first + 1; index <= job_.timeline.range.last; ++index)
        report_.window->moves += windows_->at(index) != windows_->at(index - 1);
}

const Stream* SequenceRenderer::window_of(const Stream& base) const {
    const auto found =
        std::ranges::find_if(job_.streams, [](const Stream& s) { return s.settings.window.has_value(); });
    return base.settings.is_base && found != job_.streams.end() ? &*found : nullptr;
}

void SequenceRenderer::require_all_finished() const {
    const std::int64_t finished = report_.frames_rendered + report_.frames_kept;
    if (finished < frames_in_all())
        throw WorkError("interrupted: " + std::to_string(finished) + " of " + std::to_string(frames_in_all()) +
                        " frames are finished; run the same command again to continue");
}

void SequenceRenderer::stop_if_interrupted() {
    if (!job_.interrupted)
        return;
    keep_if_finished();
    require_all_finished();
}

void SequenceRenderer::render_index(std::int64_t index) {
    bool moved = false;
    for (const Stream& stream : job_.streams) {
        if (is_kept(stream, index))
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
    task.spp = stream.settings.spp;
    const FrameTimes times = job_.timeline.times(index);
    task.head_previous = job_.timeline.path.at(times.previous_s);
    task.head = job_.timeline.path.at(times.now_s);
    task.head_next = job_.timeline.path.at(times.next_s);
    if (stream.settings.window)
        task.window_place = windows_->at(index);
    task.stop = &job_.interrupted;
    task.paths_traced = [this](std::uint64_t paths) { progress_.set(static_cast<double>(paths_ += paths)); };
    // Where light is carried on, samples go by what the frame before has left: whatever was rendered between, or kept.
    if (stream.settings.accumulates) {
        start_writing();
        finish_writing();
    }
    const std::vector<PatchAtlas::Slot> slots = plan(stream, task);
    // A sequence serves one thread at a time: this frame begins before the last one's writing does.
    FramePointer frame = begin_frame(stream, task, {times.now_s, slots, window_of(stream)});
    task.frame = frame.get();
    start_writing();
    host_.render(task);
    finish_writing();
    rendered_ = std::move(frame);
    note_ = stream.settings.name + " frame " + std::to_string(index);
    stop_if_interrupted();
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

/// Before the render ends early. A frame that was stopped before its last tile is refused, and left out.
void SequenceRenderer::keep_if_finished() {
    try {
        start_writing();
        finish_writing();
    } catch (const std::exception&) {
        // What ends the render is told in its place.
    }
}

namespace {

/// The most memory this process has held, from the kernel; 0 where it does not say.
double peak_memory_mib() {
    std::ifstream status("/proc/self/status");
    for (std::string word; status >> word;)
        if (word == "VmHWM:") {
            double kibibytes = 0;
            status >> kibibytes;
            return kibibytes / 1024;
        }
    return 0;
}

}  // namespace

void print_plan(const RenderOptions& o, const Timeline& timeline, const RenderHost& host, const std::string& command) {
    // Accumulated light, and where patches are, are carried on from frame to frame.
    const bool independent = o.accumulate == 0 && !o.patches;
    const bool in_parts = independent && host.fills_tiles() && !o.window;
    const auto first = static_cast<long long>(timeline.range.first), last = static_cast<long long>(timeline.range.last);
    if (!o.json) {
        std::printf("frames %lld to %lld of %dx%d pixels with %u samples a pixel\n", first, last, o.size.width,
                    o.size.height, o.spp);
        return;
    }
    nlohmann::json plan = {
        {"first_frame", first},       {"last_frame", last},   {"width", o.size.width},
        {"height", o.size.height},    {"spp", o.spp},         {"frames_per_second", timeline.frames_per_second},
        {"independent", independent}, {"in_parts", in_parts}, {"out", o.out.string()},
        {"threads", o.threads}};
    // Where they are set, whoever divides the job cannot set them.
    for (const auto& [name, is_set] :
         {std::pair("overwrite", o.overwrite), std::pair("follow", o.follow), std::pair("part", o.part.count > 0)})
        if (is_set)
            plan["is_set"].push_back(name);
    plan.update(cli::provenance(command));
    std::printf("%s\n", json_text(plan, 2).c_str());
}

void print_report(const RenderReport& r, const RenderHost& host, const std::string& command, bool json) {
    const double paths_per_s = static_cast<double>(r.paths) / std::max(r.render_s, 1e-9);
    const double peak_mib = peak_memory_mib();
    nlohmann::json report = {{"frames_rendered", r.frames_rendered},
                             {"frames_kept", r.frames_kept},
                             {"threads", r.threads},
                             {"load_s", r.load_s},
                             {"render_s", r.render_s},
                             {"peak_memory_mib", peak_mib},
                             {"paths", r.paths},
                             {"paths_per_s", paths_per_s}};
    const PatchReport& patches = r.patches;
    const auto frames = static_cast<double>(std::max<std::int64_t>(patches.frames, 1));
    if (patches.frames > 0)
        report["patches"] = {{"frames", patches.frames},
                             {"pixel_share", patches.pixel_share / frames},
                             {"covered_of_training", patches.covered / frames},
                             {"kept_slots", patches.kept_slots / std::max(patches.used_slots, 1.0)},
                             {"plan_s", patches.plan_s}};
    if (r.window)
        report["window"] = {{"width", r.window->grid.width},
                            {"height", r.window->grid.height},
                            {"columns", r.window->grid.columns},
                            {"moves", r.window->moves}};
    const HostFigures figures = host.figures(r.render_s, report);
    report["left_out_samples"] = figures.left_out_samples;
    report.update(cli::provenance(command));
    if (json) {
        std::printf("%s\n", json_text(report, 2).c_str());
        return;
    }
    std::printf("%lld frames rendered, %lld kept\n", static_cast<long long>(r.frames_rendered),
                static_cast<long long>(r.frames_kept));
    std::printf("load %.2f s, %s, peak memory %.0f MiB\n", report["load_s"].get<double>(), figures.loaded.c_str(),
                peak_mib);
    if (figures.left_out_samples > 0)
        std::printf("%llu samples were not finite and are left out\n",
                    static_cast<unsigned long long>(figures.left_out_samples));
    if (r.frames_rendered > 0)
        std::printf("render %.2f s on %u threads: %.3f M paths/s%s%s\n", r.render_s, r.threads, paths_per_s * 1e-6,
                    figures.rates.empty() ? "" : ", ", figures.rates.c_str());
    if (r.window)
        std::printf("window %dx%d of a sphere of %d columns, moved %lld times\n", r.window->grid.width,
                    r.window->grid.height, r.window->grid.columns, static_cast<long long>(r.window->moves));
    if (patches.frames > 0)
        std::printf("patches show %.1f %% of what eyes uncover in %.1f %% of the sphere's pixels; %.0f %% of the slots "
                    "stayed; planned in %.2f s a frame, %.1f %% of the time\n",
                    100 * patches.covered / frames, 100 * patches.pixel_share / frames,
                    100 * patches.kept_slots / std::max(patches.used_slots, 1.0), patches.plan_s / frames,
                    100 * patches.plan_s / std::max(r.render_s, 1e-9));
}

}  // namespace equistream::render_command
