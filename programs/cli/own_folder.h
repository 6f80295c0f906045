#pragma once
#include <filesystem>

namespace equistream::cli {

/// Of the running program: the others lie beside it.
std::filesystem::path own_folder();

}  // namespace equistream::cli
