#pragma once
/// A look at an EXR file's headers before OpenEXR's: that asks for as much memory as an attribute says it has.
#include <cstdint>
#include <filesystem>

namespace equistream::files {

/// Throws InputError for headers whose attributes say that they are longer than the file, or that have no end. What
/// they hold is not looked at.
void require_attributes_within(const std::filesystem::path& file, std::uintmax_t file_bytes);

}  // namespace equistream::files
