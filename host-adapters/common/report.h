#pragma once
/// What a render tells at its end.
#include "host.h"

#include <cstdint>
#include <string>

namespace equistream::render_command {

/// Sums over the frames whose patches were planned.
struct PatchReport {
    std::int64_t frames = 0;
    double pixel_share = 0;                 ///< of used slots, to the sphere's
    double covered = 0;                     ///< of what the planner's eyes uncover
    double used_slots = 0, kept_slots = 0;  ///< all; those as in the frame before
    double plan_s = 0;                      ///< part of render_s
};

struct RenderReport {
    std::int64_t frames_rendered = 0, frames_kept = 0;
    unsigned threads = 0;
    double load_s = 0;    ///< everything before the first frame
    double render_s = 0;  ///< frames, writing included
    std::uint64_t paths = 0;
    PatchReport patches;
};

/// Text or JSON on standard output.
void print_report(const RenderReport& report, const RenderHost& host, const std::string& command, bool json);

}  // namespace equistream::render_command
