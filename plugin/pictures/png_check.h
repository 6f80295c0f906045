#pragma once
/// Whether a PNG arrived as it was written.
#include <OpenImageIO/filesystem.h>

#include <optional>
#include <string>

namespace equistream {

/// What is wrong with a file that begins as a PNG does: "one that ends early", "a damaged chunk IDAT"; nothing for a
/// whole one and for what is no PNG. Looked at before libpng does, which would print what it finds. Reads from where
/// `file` stands.
std::optional<std::string> png_damage(OIIO::Filesystem::IOProxy& file);

}  // namespace equistream
