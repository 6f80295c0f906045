#pragma once
/// Which triangles an eye in a head box can see, by casting rays; never less than the rays hit.
#include "head_boxes.h"

#include <scenes/embree/bvh.h>

#include <vector>

namespace equistream {

/// By instance and triangle of its mesh: 1 where seen.
using SeenTriangles = std::vector<std::vector<std::uint8_t>>;

/// Whole spheres of rays from eyes all along the path find what is seen at a glance; triangles they miss, small ones
/// and those that peep out of narrow gaps, are then aimed at one by one.
SeenTriangles find_seen(const SceneModel& model, const Bvh& bvh, const HeadBoxes& boxes, std::int64_t rays,
                        std::uint64_t seed);

/// Adds to what is seen of one instance every triangle that shares a point with a seen one.
void add_neighbours(const Mesh& mesh, std::vector<std::uint8_t>& seen);

}  // namespace equistream
