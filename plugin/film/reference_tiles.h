#pragma once
/// Small tiles of a frame that are sampled again, many times: what noise, denoising and coding make of the picture is
/// measured there (visible_loss.h). Their samples are none of the picture's.
#include <glm/vec2.hpp>

#include <cstdint>
#include <vector>

namespace equistream {

struct ReferenceTiles {
    static constexpr int side = 4;
    static constexpr std::size_t pixels = std::size_t{side} * side;
    std::vector<glm::ivec2> corners{};  ///< upper left ones; no two tiles share a pixel
    std::uint32_t samples = 0;          ///< a pixel; 0: there are no such tiles
};

/// For a frame of so many samples a pixel, which may be the mean of so many frames. They take a fiftieth of the frame's
/// samples, one tile at least, and lie elsewhere in every frame, evenly over its pixels. Each half of their samples
/// makes a picture. Its noise is less than a fifth of the frame's as rendered, up to 16,383 samples. A denoised frame
/// may have less noise than that.
ReferenceTiles reference_tiles(glm::ivec2 size, std::uint32_t samples_per_pixel, std::uint32_t accumulated_frames,
                               std::int64_t frame_index);

}  // namespace equistream
