#pragma once
/// Files that hold a secret: their owner's alone.
#include <filesystem>
#include <functional>
#include <string>

namespace equistream {

/// False: the file is there. True: it was not, and holds `text()` now. Throws InputError where it cannot be made,
/// WorkError where it cannot be written.
bool make_private_file(const std::filesystem::path& file, const std::function<std::string()>& text);

/// Its first MiB. Throws InputError where others may read or write it, or it cannot be read.
std::string read_private_file(const std::filesystem::path& file);

}  // namespace equistream
