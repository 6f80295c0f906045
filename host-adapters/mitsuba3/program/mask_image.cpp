#include "mask_image.h"

#include <stb/stb_image_write.h>

#include <equistream/error.h>

namespace equistream::mitsuba_host {

std::vector<std::uint8_t> mask_png(const OpacityMap& map) {
    std::vector<std::uint8_t> rgba(4 * map.opacity.size(), 255);
    for (std::size_t i = 0; i < map.opacity.size(); ++i)
        rgba[4 * i + 3] = map.opacity[i] >= 0.5f ? 255 : 0;
    std::vector<std::uint8_t> png;
    const auto append = [](void* to, void* data, int size) {
        auto& bytes = *static_cast<std::vector<std::uint8_t>*>(to);
        const auto* first = static_cast<const std::uint8_t*>(data);
        bytes.insert(bytes.end(), first, first + size);
    };
    if (stbi_write_png_to_func(append, &png, map.width, map.height, 4, rgba.data(), 4 * map.width) == 0)
        throw WorkError("an opacity map could not be coded as PNG");
    return png;
}

}  // namespace equistream::mitsuba_host
