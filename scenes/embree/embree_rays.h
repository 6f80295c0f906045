#pragma once
/// Rays in Embree's own structures, ready for the calls of Bvh.
#include "bvh.h"

#include <array>
#include <limits>

namespace equistream {

inline RTCRay embree_ray(const glm::vec3& origin, const glm::vec3& direction,
                         float t_max = std::numeric_limits<float>::infinity()) {
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = t_max;
    ray.mask = ~0u;
    return ray;
}

inline RTCRayHit embree_ray_hit(const glm::vec3& origin, const glm::vec3& direction) {
    RTCRayHit query{};
    query.ray = embree_ray(origin, direction);
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return query;
}

/// Up to 16 rays for Bvh::intersect16; lanes that nobody starts are switched off.
struct RayPacket {
    alignas(64) std::array<int, 16> valid{};
    RTCRayHit16 rays{};

    void start(std::size_t lane, const glm::vec3& origin, const glm::vec3& direction, float t_min = 0,
               float t_max = std::numeric_limits<float>::infinity()) {
        valid[lane] = -1;
        rays.ray.org_x[lane] = origin.x;
        rays.ray.org_y[lane] = origin.y;
        rays.ray.org_z[lane] = origin.z;
        rays.ray.dir_x[lane] = direction.x;
        rays.ray.dir_y[lane] = direction.y;
        rays.ray.dir_z[lane] = direction.z;
        rays.ray.tnear[lane] = t_min;
        rays.ray.tfar[lane] = t_max;
        rays.ray.mask[lane] = ~0u;
        rays.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    bool started(std::size_t lane) const { return valid[lane] != 0; }
    /// After intersect16: what Bvh::resolve takes.
    RTCHit hit(std::size_t lane) const {
        RTCHit hit{};
        hit.geomID = rays.hit.geomID[lane];
        hit.primID = rays.hit.primID[lane];
        hit.instID[0] = rays.hit.instID[0][lane];
        hit.u = rays.hit.u[lane];
        hit.v = rays.hit.v[lane];
        return hit;
    }
    /// After intersect16: of the hit, or t_max.
    float distance(std::size_t lane) const { return rays.ray.tfar[lane]; }
};

}  // namespace equistream
