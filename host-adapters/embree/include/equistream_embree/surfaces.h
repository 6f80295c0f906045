#pragma once
/// Answers to geometry rays: distance, where the point was and will be, normal, albedo, ids.
#include <equistream_embree/path_tracer.h>

#include <span>

namespace equistream::embree_host {

/// World transforms of all instances at the neighbouring frames.
struct NeighbourTransforms {
    std::span<const glm::mat4> previous, next;
    std::span<const std::uint8_t> moves;  ///< by instance: whether they differ from this frame's
};

/// One unfiltered sample per ray; `surfaces` as long as `rays`.
void trace_surfaces(Worker& worker, const ShadingScene& scene, const NeighbourTransforms& neighbours,
                    std::span<const es_ray> rays, std::span<es_surface> surfaces);

}  // namespace equistream::embree_host
