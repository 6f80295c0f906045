#pragma once
/// Poses, cameras and so on as JSON: in manifests and in what `info` and `encode` print.
#include <equistream/camera.h>
#include <equistream/patches.h>
#include <equistream/visible_loss.h>

#include <nlohmann/json.hpp>

namespace equistream {

nlohmann::json pose_to_json(const Pose& pose);
nlohmann::json camera_to_json(const Camera& camera);
/// By the textures that it is given for.
nlohmann::json visible_loss_to_json(const VisibleLoss& loss);
/// What the atlases of one sequence share: all but the slots, which differ from frame to frame.
nlohmann::json patches_to_json(const PatchAtlas& atlas);

}  // namespace equistream
