#include <equistream_embree/directions.h>

#include <algorithm>

namespace equistream::embree_host {

std::uint32_t pack_direction(const glm::vec3& direction) {
    const float sum = std::abs(direction.x) + std::abs(direction.y) + std::abs(direction.z);
    if (!(sum > 0) || !std::isfinite(sum))
        return 0;  // +Z: a triangle without an area has no normal worth keeping
    float x = direction.x / sum, y = direction.y / sum;
    if (direction.z < 0) {
        const float folded_x = std::copysign(1 - std::abs(y), x);
        y = std::copysign(1 - std::abs(x), y);
        x = folded_x;
    }
    const auto bits = [](float v) {
        const auto rounded = static_cast<std::int16_t>(std::lround(std::clamp(v, -1.0f, 1.0f) * 32767.0f));
        return std::uint32_t{static_cast<std::uint16_t>(rounded)};
    };
    return bits(x) | (bits(y) << 16);
}

}  // namespace equistream::embree_host
