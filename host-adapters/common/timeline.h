#pragma once
/// Which frames there are to make, and at what times.
#include "options.h"

#include <scenes/library/scene.h>

namespace equistream::render_command {

/// Beyond the path's ends there is nothing: a neighbour is the frame itself.
struct FrameTimes {
    std::int64_t index = 0;
    double previous_s = 0, now_s = 0, next_s = 0;
};

struct Timeline {
    PosePath path;
    double frames_per_second = 30;
    std::int64_t path_frames = 1;
    cli::FrameRange range;

    FrameTimes times(std::int64_t index) const;
    double time_s(std::int64_t index) const { return static_cast<double>(index) / frames_per_second; }
};

/// Throws InputError where there is no path, or --frames leaves it.
Timeline make_timeline(const RenderOptions& options, const SceneDescription& scene);

}  // namespace equistream::render_command
