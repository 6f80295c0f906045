#pragma once
/// Sun, sky and glowing surfaces as Mitsuba emitters.
#include "materials.h"

#include <scenes/library/scene.h>

namespace equistream::mitsuba_xml {

/// A sphere around everything, in metres.
struct Bounds {
    glm::dvec3 centre{0};
    double radius_m = 0;
};

/// A sky, if it shines, with one share of the light samples. A sky's image is written here.
void add_sky(pugi::xml_node scene, const SceneDescription& description, AssetFolder& folder);

/// A disc facing the scene, so far away that all of the scene sees the same: `directional` has no penumbra. Rays pass
/// through it, as they see the sky behind our sun. One share of the light samples. Throws InputError for a sun that no
/// disc can be.
void add_sun(pugi::xml_node scene, const SceneDescription& description, const Bounds& bounds);
/// A sky that does not shine: Mitsuba refuses a scene in which no light may be sampled.
void add_darkness(pugi::xml_node scene);
/// Distance of that disc from the bounds' centre.
double sun_distance_m(const Bounds& bounds);

/// An area light on a shape. `share` of light samples, all shapes together having one; 0: found by scattered rays
/// alone.
void add_emitter(pugi::xml_node shape, const Material& material, const std::string& emission_image, double share);

/// Whether texture coordinates of a mesh map one to one onto places in [0, 1]^2: only then can Mitsuba choose points
/// on a textured light by its texture.
bool maps_one_to_one(const Mesh& mesh);

}  // namespace equistream::mitsuba_xml
