#pragma once
/// What the current context's own objects take of the GPU's memory.
#include <cstddef>

namespace equistream::gl {

/// Textures and buffers of the context that is current, by the sizes that were asked for; what the driver adds, and
/// framebuffers of windows, are not in it. Asks the driver about each: a few times a second at most.
std::size_t object_bytes();

}  // namespace equistream::gl
