#pragma once
/// The bytes that make up a model, hashed.
#include "file_bytes.h"

#include <filesystem>

namespace equistream {

/// Adds the model file and, for a .gltf, the buffers and images beside it that it names. Files that are missing are
/// left for load_model to complain about.
void add_model_to_hash(const std::filesystem::path& model, ContentHash& hash);

}  // namespace equistream
