#pragma once
/// One frame on all threads: tiles pulled from the plugin, rays traced, answers handed back.
#include <equistream/equistream.h>
#include <host-adapters/embree/surfaces.h>

#include <atomic>
#include <functional>

namespace equistream::embree_host {

struct FrameJob {
    es_frame* frame = nullptr;
    bool wants_surfaces = true, wants_guides = false, wants_ids = false;
    const TracedScene* scene = nullptr;
    NeighbourTransforms neighbours;
    unsigned threads = 1;
    const std::atomic<bool>* stop = nullptr;          ///< set: threads end after their tile
    std::function<void(std::uint64_t)> paths_traced;  ///< called by any thread, after each tile
};

/// How far rays go, on all threads; +inf for a miss.
void cast_rays(const TracedScene& scene, unsigned threads, std::span<const es_ray> rays, std::span<float> distances_m);

/// Returns when every tile is done, or `stop` was set. Rethrows what a thread threw.
RayCounts run_frame(const FrameJob& job);

}  // namespace equistream::embree_host
