#pragma once
/// Whether a PNG file arrived as it was written.
#include <filesystem>
#include <optional>
#include <string>

namespace equistream {

/// What is wrong with a file that begins as a PNG does: "one that ends early", "a damaged chunk IDAT"; nothing for a
/// whole one and for what is no PNG. Looked at before libpng does, which would print what it finds.
std::optional<std::string> png_damage(const std::filesystem::path& file);

}  // namespace equistream
