#pragma once
/// Numbers of the `geometry` fill pass: where light is looked for that a gap's surface receives.
#include <cstddef>

namespace equistream {

inline constexpr int light_tile_side = 8;
inline constexpr int light_sample_step = 2;    ///< of filled pixels, those at every second column and row are asked
inline constexpr int lit_tiles_around = 2;     ///< a tile with gaps: those whose samples are asked
inline constexpr int farthest_light_tile = 6;  ///< around a gap's own where its instance is looked for
inline constexpr std::size_t enough_light_samples = 12;
inline constexpr float min_base = 0.02f;  ///< darker surfaces' colours say little about their light
inline constexpr float min_light_weight = 1e-3f;

}  // namespace equistream
