#pragma once
/// An image file in memory (PNG, JPEG, TGA, BMP, DDS or TIFF), opened by OpenImageIO after its header has been found to
/// be in order.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace equistream {

/// OpenImageIO's name of the format ("png", "jpeg", "targa", ...): by the first bytes, else by the extension of `name`
/// for a TGA, which has no signature. Null for what EncodedImage does not open.
const char* image_format(std::span<const std::uint8_t> bytes, const std::string& name);

class EncodedImage {
public:
    /// `bytes` are borrowed. `name` is what the file was called: its extension tells a TGA, which has no signature.
    /// Throws InputError, "expected an image ..., found ...", behind "WHERE: " unless `where` is empty. What a PNG or
    /// JPEG lacks at its end is found here, other damage by reading.
    EncodedImage(std::span<const std::uint8_t> bytes, const std::string& name, const std::string& where = {});

    const OIIO::ImageSpec& spec() const { return spec_; }
    int width() const { return spec_.width; }
    int height() const { return spec_.height; }
    /// From 1 to 4.
    int channels() const { return spec_.nchannels; }
    /// Of alpha, from 0; -1 if there is none.
    int alpha_channel() const;

    /// Rows from the top, channels interleaved, alpha not multiplied in. Once only.
    std::vector<std::uint8_t> read();

private:
    [[noreturn]] void fail(const std::string& found,
                           const std::string& expected = "an image (PNG, JPEG, TGA, BMP, DDS or TIFF)") const;

    std::string where_;
    OIIO::Filesystem::IOMemReader memory_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;
};

}  // namespace equistream
