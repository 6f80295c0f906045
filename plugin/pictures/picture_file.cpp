#include "png_check.h"

#include <equistream/error.h>
#include <equistream/picture.h>
#include <equistream/sequence.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <vector>

namespace equistream {

namespace fs = std::filesystem;

ByteImage read_picture(const fs::path& file) {
    if (!fs::exists(file))
        throw InputError(file.string() + ": no such file");
    if (const auto damage = png_damage(file))
        throw InputError(expected_found(file.string(), "a whole PNG picture", *damage));
    const auto input = OIIO::ImageInput::open(file.string());
    if (!input)
        throw InputError(expected_found(file.string(), "a picture", OIIO::geterror()));
    const OIIO::ImageSpec spec = input->spec();
    if (spec.width < 1 || spec.height < 1 || spec.depth > 1 || spec.width > max_image_side ||
        spec.height > max_image_side || std::int64_t{spec.width} * spec.height > max_image_pixels)
        throw InputError(expected_found(file.string(),
                                        "a picture of at most " + std::to_string(max_image_side) + " a side",
                                        std::to_string(spec.width) + "x" + std::to_string(spec.height)));
    if (spec.nchannels < 1)
        throw InputError(expected_found(file.string(), "at least one channel", "none"));
    const int channels = spec.nchannels < 3 ? 1 : 3;
    ByteImage picture(spec.width, spec.height, channels);
    if (!input->read_image(0, 0, 0, channels, OIIO::TypeDesc::UINT8, picture.samples().data()))
        throw InputError(expected_found(file.string(), "a whole picture", input->geterror()));
    return picture;
}

void write_picture(const fs::path& file, ImageView<const std::uint8_t> picture) {
    const auto fail = [&](const std::string& why) {
        return WorkError(file.string() + ": could not be written: " + why);
    };
    const auto output = OIIO::ImageOutput::create(file.string());
    if (!output)
        throw fail(OIIO::geterror());
    if (!output->supports("ioproxy"))
        throw fail(expected_found("its extension", "png", file.extension().string()));
    OIIO::ImageSpec spec(picture.width, picture.height, picture.channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("png:compressionLevel", 4);
    // Coded in memory: a file's own buffers would hide a full disk until it is too late.
    std::vector<unsigned char> coded;
    OIIO::Filesystem::IOVecOutput memory(coded);
    if (!output->set_ioproxy(&memory) || !output->open(file.string(), spec) ||
        !output->write_image(OIIO::TypeDesc::UINT8, picture.data, OIIO::AutoStride, picture.row_stride) ||
        !output->close())
        throw fail(output->geterror());
    write_file_atomically(file, std::string(coded.begin(), coded.end()));
}

}  // namespace equistream
