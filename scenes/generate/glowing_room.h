#pragma once
/// A box seen from inside whose six sides glow with a painted texture each: renders without noise.
#include "scene_builder.h"

#include <array>
#include <string_view>

namespace equistream::generate {

/// Sides as met by someone who looks along -Z and turns right, then looks up and down from there.
enum Side { ahead, right, behind, left, above, below };
inline constexpr std::array<std::string_view, 6> side_names{"ahead", "right", "behind", "left", "above", "below"};

/// Texture x runs to the right and y down as seen from inside (above and below: as seen when tilting from ahead).
void add_glowing_room(SceneBuilder& scene, glm::vec3 size, const std::function<ByteImage(Side)>& paint_side);

}  // namespace equistream::generate
