#include "path_distance.h"

#include <algorithm>
#include <limits>

namespace equistream::mitsuba_host {

PathDistance::PathDistance(const PosePath& path) {
    double way_m = 0;
    for (const PosePath::Key& key : path.keys()) {
        if (!keys_.empty())
            way_m += glm::distance(keys_.back(), key.pose.position_m);
        keys_.push_back(key.pose.position_m);
        way_m_.push_back(way_m);
    }
}

double PathDistance::metres_to(const glm::dvec3& point) const {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < keys_.size();) {
        const glm::dvec3 from = keys_[i], along = keys_[std::min(i + 1, keys_.size() - 1)] - from;
        const double length2 = glm::dot(along, along);
        const double at = length2 > 0 ? std::clamp(glm::dot(point - from, along) / length2, 0.0, 1.0) : 0;
        nearest = std::min(nearest, glm::distance(from + at * along, point));
        i = key_after(i, std::max(0.0, glm::distance(from, point) - nearest));
    }
    return nearest;
}

std::size_t PathDistance::key_after(std::size_t key, double way_m) const {
    const double reach_m = way_m_[key] + way_m;
    std::size_t step = 1;
    while (key + step < way_m_.size() && way_m_[key + step] <= reach_m)
        step *= 2;
    const auto place = [&](std::size_t i) { return way_m_.begin() + static_cast<std::ptrdiff_t>(i); };
    const auto beyond = std::upper_bound(place(key + step / 2), place(std::min(key + step, way_m_.size())), reach_m);
    return std::max(key + 1, static_cast<std::size_t>(beyond - way_m_.begin()) - 1);
}

}  // namespace equistream::mitsuba_host
