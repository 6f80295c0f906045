#pragma once
/// What is seen in mirrors and through panes: the ray followed on to the first surface that is not sharp, and where it
/// appears to lie (equistream/virtual_image.h).
#include "surfaces.h"

namespace equistream::embree_host {

/// Fills the virtual fields of `surface`, which is what `ray` saw at `hit` and is sharp.
void follow_sharp_path(Worker& worker, const SurfacesScene& scene, const es_ray& ray, const Worker::Hit& hit,
                       es_surface& surface);

}  // namespace equistream::embree_host
