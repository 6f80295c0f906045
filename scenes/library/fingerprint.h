#pragma once
/// The bytes that depth comes from, hashed.
#include "scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace equistream {

/// Of the model file, the files beside it that it names (buffers and images of a .gltf or .glb; of an .obj its MTL
/// files and their images), its unit, and the moving objects' paths: all by content. Files that are missing are left
/// for load_model to complain about.
std::string geometry_fingerprint(const std::filesystem::path& model, double model_unit_m,
                                 const std::vector<MovingObject>& moving);

}  // namespace equistream
