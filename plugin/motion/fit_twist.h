#pragma once
/// The rigid movement that takes points to where a camera sees them later: camera resection, by Gauss-Newton on the
/// angles that are left.
#include <equistream/object_motion.h>

#include <span>

namespace equistream {

/// A surface point and the direction in which it is seen later; both along the world's axes.
struct SeenPoint {
    glm::dvec3 at_m{0, 0, 0};   ///< from the first camera's centre
    glm::dvec3 seen{0, 0, -1};  ///< unit, from the second camera's centre
};

/// `offset_m` is where the second camera is, from the first. What points hardly tell (how far along the rays few of
/// them have moved) stays at rest. There is at least one point.
RigidTransform fit_movement(std::span<const SeenPoint> points, const glm::dvec3& offset_m);

/// Angle between where a point is seen and where the movement takes it.
double angle_left_rad(const SeenPoint& point, const RigidTransform& movement, const glm::dvec3& offset_m);

}  // namespace equistream
