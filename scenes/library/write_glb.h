#pragma once
/// Writes a SceneModel as binary glTF 2.0. Objects become named nodes; placements of the same meshes share one glTF
/// mesh. Masks are written as alphaMode MASK with cutoff 1/2: the base colour texture's alpha must hold the mask.
#include "model.h"

#include <cstdint>
#include <filesystem>
#include <string>

namespace equistream {

/// The whole file as bytes: a function of the model alone. All instances of an object must share one transform.
/// Throws WorkError for a model that is too large.
std::string glb_bytes(const SceneModel& model);

/// Throws WorkError for more bytes than a GLB can have: its lengths are of 32 bits.
void require_glb_size(std::uint64_t bytes);

/// The same bytes in `file`, whole or not at all. Throws WorkError naming the file.
void write_glb(const std::filesystem::path& file, const SceneModel& model);

}  // namespace equistream
