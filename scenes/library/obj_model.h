#pragma once
/// load_model's part for Wavefront OBJ.
#include "model.h"

namespace equistream {

/// What load_model does with .obj.
SceneModel load_obj(const std::filesystem::path& file, const ModelOptions& options);

}  // namespace equistream
