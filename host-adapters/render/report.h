#pragma once
/// What a render tells at its end.
#include <equistream_render/host.h>

#include <cstdint>

namespace equistream::render_command {

struct RenderReport {
    std::int64_t frames_rendered = 0, frames_kept = 0;
    unsigned threads = 0;
    double load_s = 0;    ///< everything before the first frame
    double render_s = 0;  ///< frames, writing included
    std::uint64_t paths = 0;
};

/// Text or JSON on standard output.
void print_report(const RenderReport& report, const RenderHost& host, bool json);

}  // namespace equistream::render_command
