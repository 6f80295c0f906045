#pragma once
/// What the breakers share: a glowing room with things in it around a head at the origin that looks along -Z.
#include <scenes/generate/bundled.h>
#include <scenes/generate/scene_builder.h>

#include <cstdint>
#include <string>

namespace equistream::generate {

inline constexpr glm::vec3 stage_size_m{6, 4, 6};
/// The left eye of a head at the origin, for an interpupillary distance of 63 mm.
inline constexpr glm::vec3 left_eye_m{-0.0315f, 0, 0};

/// Light that reflects nothing, painted with clouds between a dark and a light colour, and three ruled lines a
/// texture.
std::uint32_t painted(SceneBuilder& scene, const std::string& name, std::uint32_t seed, glm::vec3 tint);

/// The room with two pillars and a table, so that there is something at every distance.
void add_stage(SceneBuilder& scene);

/// A ball that glows, painted.
void add_ball(SceneBuilder& scene, const std::string& name, glm::vec3 centre_m, float radius_m);

/// The scene as built, seen from the origin with these orientations, one a frame.
GeneratedScene finished(SceneBuilder& scene, std::initializer_list<glm::dquat> heads);

}  // namespace equistream::generate
