#pragma once
/// What the pavilion is made of, one function a part. Bearings are degrees clockwise from north (-Z), as on a map;
/// the floor's top is y = 0, its centre the origin.
#include "paintwork.h"

#include <scenes/generate/paint.h>
#include <scenes/library/scene.h>

namespace equistream::generate::pavilion {

struct Site {
    SceneBuilder& scene;
    const Paintwork& paint;
};

inline constexpr float column_ring_radius = 4.4f;
inline constexpr int column_count = 12;  ///< at 15, 45, ... degrees: bays are centred on the quarters of the compass
inline constexpr float lawn_height = -0.45f;
inline constexpr float rafter_bottom = 4.15f;
inline constexpr glm::vec2 pond_centre{17, -4};
inline constexpr float water_height = -0.95f;

glm::vec3 at_bearing(float bearing_deg, float radius, float height);
/// Puts an object there with its -Z pointing away from the centre.
glm::mat4 placed(float bearing_deg, float radius, float height);

/// Height of the ground at (x, z) outside the steps.
float ground_height(glm::vec2 xz);

/// A bevelled box whose wood texture runs along X.
Shape plank(glm::vec3 size);

void build_floor_and_steps(Site& site);
void build_columns_and_roof(Site& site);
void build_railings(Site& site);
void build_banners(Site& site);
void build_pedestals(Site& site);
void build_table(Site& site);
void build_lanterns(Site& site);
void build_ground(Site& site);
void build_path_and_signs(Site& site);
void build_tower(Site& site);
void build_boat(Site& site);
void build_clouds(Site& site);
void build_trees(Site& site);
void build_cypresses(Site& site);
void build_groves(Site& site);
void build_pots(Site& site);
void build_terrarium(Site& site);
void build_vines(Site& site);
void build_meadow(Site& site);

/// Centre and radius of the glass ball on its pedestal, which holds a little orange tree.
inline constexpr glm::vec3 glass_ball_centre{-0.72f, 1.2124f, 0.3f};
inline constexpr float glass_ball_radius = 0.25f;

inline constexpr float ball_radius = 0.28f;
/// The ball rolls without slipping.
PosePath ball_path(double duration_s, double frames_per_second);

// Shapes that plants are put together from.

/// `count` folded leaf cards on and in a ball of `radius`, pointing mostly outwards; their stalks are at their bottoms.
Shape leaf_cluster(int count, float radius, glm::vec2 card_size, std::uint64_t seed);

/// A random turn and size at a place.
glm::mat4 scattered(glm::vec3 at, float scale, Random& random);

/// A card that starts at the origin, rises along +Y, and folds along its middle line.
Shape folded_leaf(float width, float length, float fold);

}  // namespace equistream::generate::pavilion
