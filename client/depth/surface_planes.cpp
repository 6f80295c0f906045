#include "surface_planes.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace equistream {

namespace {

/// Of placed triangles, each with a number and at most a plane of its own: 20 bytes each.
constexpr std::size_t most_planes = std::size_t{1} << 25;

/// Planes seen a little while ago, by where they lie: one mesh's coplanar triangles follow each other closely.
class RecentPlanes {
public:
    std::int32_t& near(const glm::dvec3& normal, double distance, double size) {
        const auto whole = [](double x) { return static_cast<std::uint64_t>(std::llround(x)); };
        std::uint64_t hash = whole(normal.x * 4096) * 0x9e3779b97f4a7c15u;
        hash = (hash ^ whole(normal.y * 4096)) * 0xbf58476d1ce4e5b9u;
        hash = (hash ^ whole(normal.z * 4096)) * 0x94d049bb133111ebu;
        hash = (hash ^ whole(distance / size * 4096)) * 0x9e3779b97f4a7c15u;
        return slots_[hash >> 52];
    }

private:
    std::array<std::int32_t, 4096> slots_{};
};

}  // namespace

SurfacePlanes::SurfacePlanes(const SceneModel& model, std::span<const std::uint32_t> movers)
    : values_{0, 0, 0, 1, 0, 0, 0, 1} {
    std::vector<bool> moves(model.instances.size(), false);
    for (const std::uint32_t i : movers)
        moves[i] = true;
    for (std::size_t i = 0; i < model.instances.size(); ++i) {
        const Mesh& mesh = model.meshes[model.instances[i].mesh];
        const bool fits = planes_.size() + mesh.triangles.size() <= most_planes;
        first_.push_back(moves[i] || !fits ? no_planes : planes_.size());
        if (first_.back() != no_planes)
            add(mesh, glm::dmat4(model.instances[i].world_from_object));
    }
}

void SurfacePlanes::add(const Mesh& mesh, const glm::dmat4& world_from_object) {
    std::vector<glm::dvec3> corners;
    corners.reserve(mesh.positions.size());
    double size = 0;
    for (const glm::vec3& p : mesh.positions) {
        corners.emplace_back(world_from_object * glm::dvec4(p, 1));
        size = std::max({size, std::abs(corners.back().x), std::abs(corners.back().y), std::abs(corners.back().z)});
    }
    // Two units in the last place of the largest coordinate: nearer than that corners are not known.
    const double rounding_m = std::ldexp(size, -22);
    RecentPlanes recent;
    for (const auto& triangle : mesh.triangles) {
        const glm::dvec3 &a = corners[triangle[0]], &b = corners[triangle[1]], &c = corners[triangle[2]];
        const glm::dvec3 across = glm::cross(b - a, c - a);
        const double twice_area = glm::length(across);
        if (!(twice_area > 0)) {
            planes_.push_back(none);
            continue;
        }
        // Both sides of a surface are one plane: the normal's largest component is positive.
        glm::dvec3 normal = across / twice_area;
        const glm::dvec3 sizes = glm::abs(normal);
        const int axis = sizes.x >= sizes.y ? sizes.x >= sizes.z ? 0 : 2 : sizes.y >= sizes.z ? 1 : 2;
        if (normal[axis] < 0)
            normal = -normal;
        normal = glm::dvec3(glm::vec3(normal));
        const double distance = glm::dot(normal, (a + b + c) / 3.0);
        std::int32_t& known = recent.near(normal, distance, size);
        const auto lies_in = [&](std::int32_t plane, const glm::dvec3& p) {
            const float* v = values_.data() + 4 * std::ptrdiff_t(plane);
            return std::abs(v[0] * p.x + v[1] * p.y + v[2] * p.z - v[3]) <= rounding_m;
        };
        if (known == none || !lies_in(known, a) || !lies_in(known, b) || !lies_in(known, c)) {
            known = static_cast<std::int32_t>(values_.size() / 4);
            values_.insert(values_.end(), {float(normal.x), float(normal.y), float(normal.z), float(distance)});
        }
        planes_.push_back(known);
    }
}

}  // namespace equistream
