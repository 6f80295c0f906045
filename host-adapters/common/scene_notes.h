#pragma once
/// What numbers of a scene cost in frames of half and single precision.
#include <scenes/library/scene.h>

#include <string>
#include <vector>

namespace equistream::render_command {

/// A sentence or two for the user on each: an exposure at which frames cannot hold white, and a camera so far from the
/// world's origin that rounding shows. `path` is the camera's. Pure.
std::vector<std::string> scene_notes(const SceneDescription& scene, const PosePath& path);

}  // namespace equistream::render_command
