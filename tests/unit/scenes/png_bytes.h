#pragma once
/// An RGBA PNG in memory, by OpenImageIO's writer.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <string>
#include <vector>

namespace equistream::test {

inline std::string png_rgba(int width, int height, const std::vector<std::uint8_t>& rgba) {
    OIIO::Filesystem::IOVecOutput memory;
    const auto output = OIIO::ImageOutput::create("png");
    const OIIO::ImageSpec spec(width, height, 4, OIIO::TypeDesc::UINT8);
    output->set_ioproxy(&memory);
    output->open("memory.png", spec);
    output->write_image(OIIO::TypeDesc::UINT8, rgba.data());
    output->close();
    const auto& bytes = memory.buffer();
    return {bytes.begin(), bytes.end()};
}

}  // namespace equistream::test
