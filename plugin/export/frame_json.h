#pragma once
/// Poses and cameras as JSON: in manifests and in what `info` prints.
#include <equistream/camera.h>
#include <equistream/patches.h>

#include <nlohmann/json.hpp>

namespace equistream {

nlohmann::json pose_to_json(const Pose& pose);
nlohmann::json camera_to_json(const Camera& camera);
/// What the atlases of one sequence share: all but the slots, which differ from frame to frame.
nlohmann::json patches_to_json(const PatchAtlas& atlas);

}  // namespace equistream
