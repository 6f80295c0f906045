#pragma once
/// Answers to geometry rays: distance, where the point was and will be, normal, albedo, ids, what a mirror shows.
#include "path_tracer.h"

#include <span>

namespace equistream::embree_host {

/// World transforms of all instances at the neighbouring frames.
struct NeighbourTransforms {
    std::span<const glm::mat4> previous, next;
    std::span<const std::uint8_t> moves;  ///< by instance: whether they differ from this frame's
};

/// What surfaces are told from.
struct SurfacesScene {
    const ShadingScene& shading;
    NeighbourTransforms neighbours;
};

/// Where a point of a surface is at the neighbouring frames.
struct NeighbourPoints {
    glm::vec3 previous, next;
};
NeighbourPoints neighbour_points(const SurfacesScene& scene, const HitId& hit, const glm::vec3& position);

/// One unfiltered sample per ray; `surfaces` as long as `rays`.
void trace_surfaces(Worker& worker, const SurfacesScene& scene, std::span<const es_ray> rays,
                    std::span<es_surface> surfaces);

// What is seen in mirrors and through panes: the ray followed on to the first surface that is not sharp, and where it
// appears to lie (equistream/virtual_image.h).

/// Fills the virtual fields of `surface`, which is what `ray` saw at `hit` and is sharp.
void follow_sharp_path(Worker& worker, const SurfacesScene& scene, const es_ray& ray, const Worker::Hit& hit,
                       es_surface& surface);

}  // namespace equistream::embree_host
