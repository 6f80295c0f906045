#pragma once
/// Mitsuba's analytic shapes as triangles. A triangle stands on either side of the surface by at most a tolerance.
#include <equistream/camera.h>
#include <scenes/library/model.h>

#include <optional>
#include <string>

namespace equistream::mitsuba_host {

struct Tessellation {
    Mesh mesh;             ///< in the space that `to_world` leads to
    bool coarser = false;  ///< the tolerance would have taken more triangles than one shape may have
};

/// Whether `class_name` is one of those known here: Sphere, Disk, Rectangle, Cylinder.
bool is_analytic(const std::string& class_name);

/// Texture coordinates are Mitsuba's, but for a disk's, which are polar.
Tessellation tessellate(const std::string& class_name, const glm::dmat4& to_world, double tolerance);

}  // namespace equistream::mitsuba_host
