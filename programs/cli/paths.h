#pragma once
/// Checks of the files that a command writes, made before its work begins.
#include <filesystem>
#include <string>
#include <vector>

namespace equistream::cli {

/// Throws InputError "--out FILE: ..." where the file's folder cannot be written to, or where it is a folder itself.
void require_writable_file(const std::filesystem::path& file);

/// Throws InputError "OPTION TARGET: ..." where `target` is one of the files or folders that are read, under any name.
void require_not_read(const std::string& option, const std::filesystem::path& target,
                      const std::vector<std::filesystem::path>& read);

/// The same where `target` lies in one of the folders that are read.
void require_apart(const std::string& option, const std::filesystem::path& target,
                   const std::vector<std::filesystem::path>& read);

}  // namespace equistream::cli
