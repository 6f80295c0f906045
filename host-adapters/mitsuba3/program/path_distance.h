#pragma once
/// How near a camera path comes to a point: asked for each vertex of each shape, of paths of an hour.
#include <scenes/library/scene.h>

#include <cstddef>
#include <vector>

namespace equistream::mitsuba_host {

class PathDistance {
public:
    /// Of a path with a key.
    explicit PathDistance(const PosePath& path);

    /// To the nearest point of straight lines between keys. Most keys need no look: where a key is further away than
    /// the nearest point so far, a stretch of path from there that is shorter than the difference cannot come nearer.
    double metres_to(const glm::dvec3& point) const;
    /// The key to look at after `key`: the last one that the path reaches within `way_m`, or at least the next.
    std::size_t key_after(std::size_t key, double way_m) const;

private:
    std::vector<glm::dvec3> keys_;
    std::vector<double> way_m_;  // by key: the path's length up to it
};

}  // namespace equistream::mitsuba_host
