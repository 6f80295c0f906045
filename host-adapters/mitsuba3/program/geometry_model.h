#pragma once
/// A scene of Mitsuba's as the geometry that a client needs, in our world: ready to be written as GLB.
#include "world_map.h"

#include <host-adapters/mitsuba3/embed/embedded_scene.h>
#include <scenes/library/scene.h>

#include <cstdint>
#include <string>
#include <vector>

namespace equistream::mitsuba_host {

/// Where eyes may be: within a ball of this radius around every point of the path.
struct HeadBox {
    PosePath path;
    double radius_m = 0;
};

struct GeometryModel {
    SceneModel model;
    std::vector<std::string> notes;  ///< what could not be exported, and what is coarser than wanted: one line each
};

/// Meshes and instances as they are. Analytic shapes as triangles that are off the surface by no more than a sixteenth
/// of what bound.h grants geometry's quarter of the budget e at a silhouette, e (r - B): r from the head box to the
/// shape. A point seen at the angle t to the normal is then off by less than e (r - B) / 16 cos t along its ray.
GeometryModel geometry_model(EmbeddedScene& scene, const WorldMap& world, const HeadBox& box);

// What cuts holes, as a picture.

/// PNG, RGBA: alpha 255 where the opacity is one half or more, else 0.
std::vector<std::uint8_t> mask_png(const OpacityMap& map);

}  // namespace equistream::mitsuba_host
