#include "directions.h"

namespace equistream::embree_host {

PackedDirection pack_direction(const glm::vec3& direction) {
    const float length = glm::length(direction);
    if (!(length > 0) || !std::isfinite(length))
        return {};
    const auto packed = [&](float v) { return static_cast<std::int16_t>(std::lround(v / length * 32767)); };
    return {packed(direction.x), packed(direction.y), packed(direction.z)};
}

}  // namespace equistream::embree_host
