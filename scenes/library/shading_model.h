#pragma once
/// What every renderer of our scenes takes a material and a render to be, unless told otherwise; the formulas
/// themselves are each renderer's.
#include <cstdint>

namespace equistream {

/// Below this roughness a surface is a mirror.
inline constexpr float mirror_roughness = 0.03f;

/// Scatterings of a path at most, straight passes through glass not counted.
inline constexpr std::uint32_t default_max_bounces = 8;

}  // namespace equistream
