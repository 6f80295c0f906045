#pragma once
/// Which patches each frame of a render shows: planned with the host's own rays, so that any host will do, and with the
/// frame before, so that blocks keep their slots. Where that one was not rendered now it is read from its file: a
/// render that was interrupted goes on with the same slots.
#include "host.h"

#include <plugin/patches/planner.h>

namespace equistream::render_command {

/// What the planner is asked for. Throws InputError where there is no head box to plan for.
PatchSettings patch_settings(const RenderOptions& options, double head_radius_m);

class FramePatches {
public:
    FramePatches(const RenderOptions& options, double head_radius_m);

    /// The host has been moved to the frame's time.
    PatchPlan plan(RenderHost& host, const FrameTask& task);

private:
    std::optional<PatchAtlas> atlas_before(std::int64_t index) const;

    const RenderOptions& options_;
    PatchSettings settings_;
    std::int64_t last_index_ = -1;
    std::optional<PatchAtlas> last_;
};

}  // namespace equistream::render_command
