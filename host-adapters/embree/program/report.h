#pragma once
/// What a render tells at its end.
#include <equistream_embree/path_tracer.h>

#include <cstdint>

namespace equistream::embree_host {

struct RenderReport {
    std::int64_t frames_rendered = 0, frames_kept = 0;
    unsigned threads = 0;
    double load_s = 0;  ///< model, textures, shading data
    double bvh_s = 0;
    double render_s = 0;  ///< frames, writing included
    std::uint64_t triangles = 0, unique_triangles = 0;
    std::size_t bvh_bytes = 0;
    RayCounts counts;
};

/// Text or JSON on standard output.
void print_report(const RenderReport& report, bool json);

}  // namespace equistream::embree_host
