#pragma once
/// Poses and cameras as JSON: in manifests and in what `info` prints.
#include <equistream/camera.h>

#include <nlohmann/json.hpp>

namespace equistream {

nlohmann::json pose_to_json(const Pose& pose);
nlohmann::json camera_to_json(const Camera& camera);

}  // namespace equistream
