#include "tiles.h"

#include <equistream/image.h>

#include <algorithm>
#include <cmath>

namespace equistream::mitsuba_xml {

std::optional<Tiles> tiles_along_v(const SceneModel& model, int height,
                                   const std::function<bool(const Material&)>& uses) {
    float low = 0, high = 1;
    for (const Mesh& mesh : model.meshes) {
        if (!uses(model.materials[std::min<std::size_t>(mesh.material, model.materials.size() - 1)]))
            continue;
        for (const glm::vec2& uv : mesh.uvs) {
            if (!std::isfinite(uv.y))
                return std::nullopt;
            low = std::min(low, uv.y);
            high = std::max(high, uv.y);
        }
    }
    const double count = std::ceil(high) - std::floor(low) + 2.0;
    if (count * height > max_image_side)
        return std::nullopt;
    return Tiles{static_cast<int>(std::floor(low)) - 1, static_cast<int>(count)};
}

std::vector<int> rows_of(const Tiles& tiles, int height, Wrap wrap_v) {
    std::vector<int> rows;
    for (int tile = tiles.first; tile < tiles.first + tiles.count; ++tile)
        for (int y = 0; y < height; ++y) {
            if (wrap_v == Wrap::clamp)
                rows.push_back(tile < 0 ? 0 : tile > 0 ? height - 1 : y);
            else
                rows.push_back(wrap_v == Wrap::mirror && tile % 2 != 0 ? height - 1 - y : y);
        }
    return rows;
}

}  // namespace equistream::mitsuba_xml
