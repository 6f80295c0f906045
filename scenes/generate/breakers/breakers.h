#pragma once
/// Scenes that break reprojection (tests/stress). Each has one knob, its first option.
#include <scenes/generate/bundled.h>
#include <scenes/generate/scene_builder.h>

#include <cstdint>
#include <string>

namespace equistream::generate {

GeneratedScene make_leaf(const GeneratorValues& values);
GeneratedScene make_near(const GeneratorValues& values);
GeneratedScene make_poles(const GeneratorValues& values);
GeneratedScene make_seam(const GeneratorValues& values);
GeneratedScene make_wires(const GeneratorValues& values);
GeneratedScene make_mirror(const GeneratorValues& values);
GeneratedScene make_glass(const GeneratorValues& values);
GeneratedScene make_inside(const GeneratorValues& values);
GeneratedScene make_grazing(const GeneratorValues& values);
GeneratedScene make_sky(const GeneratorValues& values);

inline constexpr GeneratorOption leaf_options[] = {{"distance_m", "0.15", "of the leaf from the left eye"}};
inline constexpr GeneratorOption near_options[] = {
    {"distance_m", "0.3", "of the ball's surface from the head's centre"}};
inline constexpr GeneratorOption poles_options[] = {
    {"pitch_deg", "90", "how far the head looks up in frame 0 and down in frame 1; the other way round below 0"}};
inline constexpr GeneratorOption seam_options[] = {
    {"offset_deg", "0", "from straight behind, where the sphere's seam is, to what the head looks at"}};
inline constexpr GeneratorOption wires_options[] = {
    {"width_px", "1", "of a wire, in pixels of a view with the focal length focal_px"},
    {"focal_px", "960", "focal length that width_px is meant for"}};
inline constexpr GeneratorOption mirror_options[] = {{"behind_m", "1.5", "from the mirror to what it reflects"}};
inline constexpr GeneratorOption glass_options[] = {{"behind_m", "1", "from the pane to what is seen through it"}};
inline constexpr GeneratorOption inside_options[] = {
    {"depth_m", "0", "of the head's centre in a block; below 0 it is still before it"}};
inline constexpr GeneratorOption grazing_options[] = {{"height_m", "0.2", "of the eyes above the ground"}};
inline constexpr GeneratorOption sky_options[] = {{"distance_m", "0.3", "of the railing before the sky"}};

// What the breakers share: a glowing room with things in it around a head at the origin that looks along -Z.

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
