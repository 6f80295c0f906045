#pragma once
/// The pavilion's materials.
#include <scenes/generate/scene_builder.h>

namespace equistream::generate::pavilion {

struct Paintwork {
    std::uint32_t tiles, medallion, dark_marble, limestone, wood, iron, brass, copper, mirror, tinted_glass;
    std::uint32_t terracotta, soil, china, tea, lamp, orange, book, beach_ball, sail, cloud;
    std::uint32_t lawn, far_land, water, paving, bark, blade_green, blade_straw, petal_red, petal_white, petal_blue;
    std::uint32_t twig_leaf, ivy_leaf, long_leaf, cypress_leaf;
    std::uint32_t banners[4], sign_north, sign_east;
};

inline constexpr float pi_f = 3.14159265f;

/// Paints every texture and adds every material.
Paintwork paint_all(SceneBuilder& scene);

// Textures, by subject; each is a function of nothing but its arguments.
ByteImage paint_tiles();
ByteImage paint_medallion();
ByteImage paint_dark_marble();
ByteImage paint_limestone();
ByteImage paint_wood();
ByteImage paint_paving();
ByteImage paint_lawn();
ByteImage paint_far_land();
ByteImage paint_bark();
ByteImage paint_banner(int which);
ByteImage paint_sign(std::string_view text, bool arrow_right);
ByteImage paint_beach_ball();
ByteImage paint_twig();
ByteImage paint_ivy_leaf();
ByteImage paint_long_leaf();
ByteImage paint_cypress();

/// The lawn's mean colour, which the far land starts from (display-referred).
inline constexpr glm::vec3 lawn_colour{0.36f, 0.43f, 0.17f};

}  // namespace equistream::generate::pavilion
