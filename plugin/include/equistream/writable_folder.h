#pragma once
#include <filesystem>

namespace equistream {

/// Makes sure that files can be made in a folder, creating it if need be; throws InputError naming it.
void require_writable_folder(const std::filesystem::path& folder);

}  // namespace equistream
