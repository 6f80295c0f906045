#pragma once
/// Moving regions as the bytes that travel with each of a main track's pictures (docs/stream-format.md, "Motion"): 56 a
/// region, and some 6 bits a row of its pixels.
#include <equistream/object_motion.h>

#include <cstdint>
#include <span>
#include <vector>

namespace equistream {

/// Throws InputError for regions that are not sound in a picture of this size. Nothing that moves is no bytes.
std::vector<std::uint8_t> pack_motion_table(const std::vector<MovingRegion>& regions, int width, int height);

/// Throws WorkError for bytes that no regions were packed into.
std::vector<MovingRegion> unpack_motion_table(std::span<const std::uint8_t> bytes, int width, int height);

}  // namespace equistream
