#pragma once
/// What the tests of the Bvh share: rays, shapes, and an intersection that owes nothing to Embree.
#include <scenes/embree/embree_rays.h>

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace equistream::test {

struct Ray {
    glm::vec3 origin;
    glm::vec3 direction;
};

inline RTCRayHit embree_ray(const Ray& ray) {
    return embree_ray_hit(ray.origin, ray.direction);
}

struct Hit {
    double distance = std::numeric_limits<double>::infinity();
    HitId id;
};

inline Hit trace(const Bvh& bvh, const Ray& ray) {
    RTCRayHit r = embree_ray(ray);
    bvh.intersect1(r);
    Hit hit;
    hit.id = bvh.resolve(r.hit);
    if (hit.id.instance != no_index)
        hit.distance = static_cast<double>(r.ray.tfar);
    return hit;
}

/// Moeller and Trumbore 1997, two-sided, in double precision: (t, u, v), v and w the weights of b and c.
inline std::optional<glm::dvec3> intersect_triangle(const Ray& ray, const glm::dvec3& a, const glm::dvec3& b,
                                                    const glm::dvec3& c) {
    const glm::dvec3 d(ray.direction);
    const glm::dvec3 ab = b - a;
    const glm::dvec3 ac = c - a;
    const glm::dvec3 p = glm::cross(d, ac);
    const double determinant = glm::dot(ab, p);
    if (determinant == 0)
        return std::nullopt;
    const glm::dvec3 s = glm::dvec3(ray.origin) - a;
    const double u = glm::dot(s, p) / determinant;
    const glm::dvec3 q = glm::cross(s, ab);
    const double v = glm::dot(d, q) / determinant;
    const double t = glm::dot(ac, q) / determinant;
    if (u < 0 || v < 0 || u + v > 1 || t < 0)
        return std::nullopt;
    return glm::dvec3(t, u, v);
}

struct ReferenceHits {
    Hit nearest;
    double second = std::numeric_limits<double>::infinity();  ///< distance of the hit behind the nearest
};

inline ReferenceHits trace_all(const SceneModel& model, const std::vector<glm::mat4>& world_from_object,
                               const Ray& ray) {
    ReferenceHits hits;
    for (std::uint32_t i = 0; i < model.instances.size(); ++i) {
        const Mesh& mesh = model.meshes[model.instances[i].mesh];
        const glm::dmat4 m(world_from_object[i]);
        const auto world = [&](std::uint32_t v) {
            return glm::dvec3(m * glm::dvec4(glm::dvec3(mesh.positions[v]), 1));
        };
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            const glm::uvec3& corners = mesh.triangles[t];
            const auto found = intersect_triangle(ray, world(corners.x), world(corners.y), world(corners.z));
            if (!found)
                continue;
            if (found->x < hits.nearest.distance) {
                hits.second = hits.nearest.distance;
                hits.nearest.distance = found->x;
                hits.nearest.id = {i, t, static_cast<float>(found->y), static_cast<float>(found->z)};
            } else {
                hits.second = std::min(hits.second, found->x);
            }
        }
    }
    return hits;
}

inline std::vector<glm::mat4> rest_transforms(const SceneModel& model) {
    std::vector<glm::mat4> transforms;
    for (const Instance& instance : model.instances)
        transforms.push_back(instance.world_from_object);
    return transforms;
}

inline glm::vec3 random_direction(std::mt19937& random) {
    std::normal_distribution<float> normal;
    return glm::normalize(glm::vec3(normal(random), normal(random), normal(random)));
}

/// An icosahedron whose faces are quartered `levels` times, all vertices at `radius`; vertices are shared.
inline Mesh icosphere(int levels, float radius) {
    Mesh mesh;
    const float g = (1 + std::sqrt(5.0f)) / 2;
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-g, g}) {
            mesh.positions.push_back({0, a, b});
            mesh.positions.push_back({a, b, 0});
            mesh.positions.push_back({b, 0, a});
        }
    // Faces are the triples of mutually adjacent vertices: those 2 apart.
    const auto adjacent = [&](std::uint32_t i, std::uint32_t j) {
        return std::abs(glm::length(mesh.positions[i] - mesh.positions[j]) - 2) < 0.01f;
    };
    for (std::uint32_t i = 0; i < 12; ++i)
        for (std::uint32_t j = i + 1; j < 12; ++j)
            for (std::uint32_t k = j + 1; k < 12; ++k)
                if (adjacent(i, j) && adjacent(j, k) && adjacent(k, i))
                    mesh.triangles.push_back({i, j, k});
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t i, std::uint32_t j) {
            const auto [entry, added] =
                middles.try_emplace(std::minmax(i, j), static_cast<std::uint32_t>(mesh.positions.size()));
            if (added)
                mesh.positions.push_back(glm::normalize(mesh.positions[i] + mesh.positions[j]));
            return entry->second;
        };
        for (glm::vec3& p : mesh.positions)
            p = glm::normalize(p);
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3& t : mesh.triangles) {
            const std::uint32_t xy = middle(t.x, t.y), yz = middle(t.y, t.z), zx = middle(t.z, t.x);
            finer.insert(finer.end(), {{t.x, xy, zx}, {xy, t.y, yz}, {zx, yz, t.z}, {xy, yz, zx}});
        }
        mesh.triangles = std::move(finer);
    }
    for (glm::vec3& p : mesh.positions)
        p = glm::normalize(p) * radius;
    return mesh;
}

/// Triangles of random size and place within a unit cube.
inline Mesh triangle_soup(std::size_t count, std::mt19937& random) {
    std::uniform_real_distribution<float> uniform(-0.5f, 0.5f);
    Mesh mesh;
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::vec3 centre(uniform(random), uniform(random), uniform(random));
        for (int c = 0; c < 3; ++c)
            mesh.positions.push_back(centre + 0.4f * glm::vec3(uniform(random), uniform(random), uniform(random)));
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    return mesh;
}

}  // namespace equistream::test
