#include "encoded_image.h"

#include "png_check.h"

#include <equistream/error.h>
#include <equistream/image.h>
#include <equistream/text.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace equistream {
namespace {

struct Signature {
    std::string_view bytes;
    const char* format;  // OpenImageIO's name
};

constexpr std::array signatures = {Signature{"\x89PNG", "png"}, Signature{"\xff\xd8", "jpeg"}, Signature{"DDS ", "dds"},
                                   Signature{"BM", "bmp"},      Signature{"II*", "tiff"},      Signature{"MM", "tiff"}};

/// libjpeg fills what a cut file lacks with grey and calls it a warning: look for the end marker before it does.
bool is_cut_jpeg(std::span<const std::uint8_t> bytes) {
    constexpr std::array<std::uint8_t, 2> begin = {0xff, 0xd8}, end = {0xff, 0xd9};
    return bytes.size() > 1 && std::equal(begin.begin(), begin.end(), bytes.begin()) &&
           std::find_end(bytes.begin(), bytes.end(), end.begin(), end.end()) == bytes.end();
}

}  // namespace

const char* image_format(std::span<const std::uint8_t> bytes, const std::string& name) {
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (const Signature& signature : signatures)
        if (text.starts_with(signature.bytes))
            return signature.format;
    std::string extension = name.size() > 4 ? name.substr(name.size() - 4) : name;
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension == ".tga" ? "targa" : nullptr;
}

EncodedImage::EncodedImage(std::span<const std::uint8_t> bytes, const std::string& name, const std::string& where)
    : where_(where),
      // IOMemReader only reads, but its constructor takes a plain pointer.
      memory_(const_cast<std::uint8_t*>(bytes.data()), bytes.size()) {
    if (const auto damage = png_damage(memory_))
        fail(*damage, "a whole PNG image");
    memory_.seek(0);
    if (is_cut_jpeg(bytes))
        fail("one without its end", "a whole JPEG image");
    const char* format = image_format(bytes, name);
    if (!format)
        fail("other data");
    input_ = OIIO::ImageInput::create(format);
    if (!input_)
        fail(OIIO::geterror());
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    if (!input_->supports("ioproxy") || !input_->set_ioproxy(&memory_) || !input_->open(name, spec_, config))
        fail(input_->geterror());
    if (spec_.width < 1 || spec_.height < 1 || spec_.width > max_image_side || spec_.height > max_image_side ||
        spec_.depth > 1 || spec_.nchannels < 1 || spec_.nchannels > 4 ||
        std::int64_t{spec_.width} * spec_.height > max_image_pixels)
        fail(size_text(spec_.width, spec_.height) + " with " + std::to_string(spec_.nchannels) + " channels");
}

int EncodedImage::alpha_channel() const {
    return channels() == 2 || channels() == 4 ? channels() - 1 : -1;
}

std::vector<std::uint8_t> EncodedImage::read() {
    std::vector<std::uint8_t> samples(static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()) *
                                      static_cast<std::size_t>(channels()));
    if (!input_->read_image(0, 0, 0, channels(), OIIO::TypeDesc::UINT8, samples.data()))
        fail(input_->geterror());
    return samples;
}

void EncodedImage::fail(const std::string& found, const std::string& expected) const {
    const std::string text = "expected " + expected + ", found " + quotable(found, 300);
    throw InputError(where_.empty() ? text : quotable(where_, 4096) + ": " + text);
}

}  // namespace equistream
