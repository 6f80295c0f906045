#pragma once
/// The bytes that depth comes from, hashed.
#include <equistream_scene/scene.h>

#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

/// Of the model file, the buffers and images beside it that it names (.gltf or .glb), and the moving objects' paths:
/// all by content. Files that are missing are left for load_model to complain about.
std::string geometry_fingerprint(const std::filesystem::path& model, const std::vector<MovingObject>& moving);

}  // namespace equistream
