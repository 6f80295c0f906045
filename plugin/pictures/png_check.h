#pragma once
/// Whether a PNG arrived as it was written.
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

namespace equistream {

/// What is wrong with a file (or its bytes) that begins as a PNG does: "one that ends early", "a damaged chunk IDAT";
/// nothing for a whole one and for what is no PNG. Looked at before libpng does, which would print what it finds.
std::optional<std::string> png_damage(const std::filesystem::path& file);
std::optional<std::string> png_damage(std::span<const std::uint8_t> bytes);

}  // namespace equistream
