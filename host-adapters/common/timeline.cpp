#include "timeline.h"

#include <equistream/error.h>

#include <cmath>
#include <cstdio>

namespace equistream::render_command {

FrameTimes Timeline::times(std::int64_t index) const {
    const std::int64_t previous = index > 0 ? index - 1 : index;
    const std::int64_t next = index + 1 < path_frames ? index + 1 : index;
    return {index, time_s(previous), time_s(index), time_s(next)};
}

namespace {

void note_clock(const PosePath& path, const std::string& name) {
    const std::string note = clock_note(path, name);
    if (!note.empty())
        std::fprintf(stderr, "equistream render: note: %s\n", note.c_str());
}

}  // namespace

Timeline make_timeline(const RenderOptions& options, const SceneDescription& scene) {
    Timeline t;
    t.path = options.path.empty() ? scene.camera_path : read_path_csv(options.path);
    if (t.path.empty())
        throw InputError(expected_found(scene.file.string(), "a camera path (or --path)", "none"));
    note_clock(t.path, options.path.empty() ? "the camera path of " + scene.file.string() : options.path.string());
    for (const MovingObject& moving : scene.moving)
        note_clock(moving.path, "the path of " + moving.object);
    t.frames_per_second = options.frames_per_second.value_or(scene.frames_per_second);
    // The small term keeps a last key that falls on a frame from being lost to rounding.
    t.path_frames = static_cast<std::int64_t>(std::floor(t.path.duration_s() * t.frames_per_second + 1e-6)) + 1;
    t.range = options.frames.value_or(cli::FrameRange{0, t.path_frames - 1});
    if (t.range.last >= t.path_frames)
        throw InputError(expected_found("--frames", "frames within the path's 0-" + std::to_string(t.path_frames - 1),
                                        std::to_string(t.range.first) + "-" + std::to_string(t.range.last)));
    return t;
}

}  // namespace equistream::render_command
