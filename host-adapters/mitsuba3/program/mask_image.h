#pragma once
/// What cuts holes, as a picture.
#include <host-adapters/mitsuba3/embed/embedded_scene.h>

#include <cstdint>
#include <vector>

namespace equistream::mitsuba_host {

/// PNG, RGBA: alpha 255 where the opacity is one half or more, else 0.
std::vector<std::uint8_t> mask_png(const OpacityMap& map);

}  // namespace equistream::mitsuba_host
