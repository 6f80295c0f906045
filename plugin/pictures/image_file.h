#pragma once
/// OpenImageIO's reader of an image file, whatever the file is called.
#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <memory>
#include <string>

namespace equistream {

/// Null where it cannot be read; `problem` says why.
std::unique_ptr<OIIO::ImageInput> open_image_file(const std::filesystem::path& file, std::string& problem);

}  // namespace equistream
