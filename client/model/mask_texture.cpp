#include "mask_texture.h"

#include <equistream/error.h>

#include <stb/stb_image_write.h>

namespace equistream {

namespace {

void append(void* bytes, void* data, int size) {
    const auto* first = static_cast<const std::uint8_t*>(data);
    auto* to = static_cast<std::vector<std::uint8_t>*>(bytes);
    to->insert(to->end(), first, first + size);
}

}  // namespace

Texture mask_texture(const AlphaMask& mask, const std::string& name) {
    std::vector<std::uint8_t> grey_alpha(mask.opaque.size() * 2, 255);
    for (std::size_t i = 0; i < mask.opaque.size(); ++i)
        grey_alpha[2 * i + 1] = mask.opaque[i];
    Texture texture;
    texture.name = name;
    texture.mime_type = "image/png";
    texture.wrap_u = mask.wrap_u;
    texture.wrap_v = mask.wrap_v;
    texture.nearest = true;
    if (stbi_write_png_to_func(append, &texture.encoded, mask.width, mask.height, 2, grey_alpha.data(),
                               2 * mask.width) == 0)
        throw WorkError("the alpha mask of material '" + quotable(name, 300) + "' could not be encoded");
    return texture;
}

}  // namespace equistream
