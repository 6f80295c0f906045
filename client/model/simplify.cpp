#include "simplify.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <compare>

namespace equistream {

namespace {

/// One pass: clusters are cubes whose side is the power of two that is at most `side` times their distance; their
/// lattice is shifted by `shift` of a side.
struct Pass {
    double side, shift;
};
constexpr Pass passes[] = {{1.0 / 2, 0}, {1.0 / 2, 0.5}, {1, 0.25}, {1, 0.75}};
constexpr int min_side_log2 = -8;

struct ClusterKey {
    std::int32_t level = 0, x = 0, y = 0, z = 0;
    auto operator<=>(const ClusterKey&) const = default;
};

struct Placed {
    ClusterKey key;
    std::uint32_t triangle = 0;
    float allowed_m = 0;  ///< 0: stays as it is
    auto operator<=>(const Placed& other) const {
        return key != other.key ? key <=> other.key : triangle <=> other.triangle;
    }
    bool operator==(const Placed& other) const { return key == other.key && triangle == other.triangle; }
};

ClusterKey key_of(const TriangleCorners& t, double distance_m, const Pass& pass) {
    ClusterKey key;
    key.level = std::max(min_side_log2, std::ilogb(std::max(distance_m, 1e-6) * pass.side));
    const double side = std::ldexp(1.0, key.level);
    const glm::dvec3 middle = (glm::dvec3(t.a) + glm::dvec3(t.b) + glm::dvec3(t.c)) / 3.0;
    const glm::ivec3 cell(glm::floor(middle / side + pass.shift));
    return {key.level, cell.x, cell.y, cell.z};
}

Placed place(const StaticGeometry& geometry, std::uint32_t index, const HeadBoxes& boxes, double error_rad,
             const Pass& pass) {
    const glm::uvec3 t = geometry.triangles[index];
    const TriangleCorners corners{geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]};
    const int strictness = std::max({geometry.strictness[t.x], geometry.strictness[t.y], geometry.strictness[t.z]});
    const double distance_m = boxes.distance_m(corners);
    const double allowed = strictness >= StaticGeometry::exact
                               ? 0
                               : std::ldexp(boxes.allowed_m(corners, distance_m, error_rad), -2 * strictness);
    return {key_of(corners, distance_m, pass), index, float(allowed)};
}

/// A cluster's triangles, in the numbers of the whole.
std::vector<glm::uvec3> simplify_cluster(const StaticGeometry& geometry, std::span<const Placed> cluster) {
    std::vector<glm::uvec3> kept, free;
    float allowed = std::numeric_limits<float>::infinity();
    for (const Placed& placed : cluster) {
        const glm::uvec3 t = geometry.triangles[placed.triangle];
        (placed.allowed_m > 0 ? free : kept).push_back(t);
        if (placed.allowed_m > 0)
            allowed = std::min(allowed, placed.allowed_m);
    }
    if (free.size() < 2) {
        kept.insert(kept.end(), free.begin(), free.end());
        return kept;
    }
    std::vector<std::uint32_t> vertices;
    for (const glm::uvec3& t : free)
        vertices.insert(vertices.end(), {t.x, t.y, t.z});
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    const auto local = [&](unsigned i) {
        return unsigned(std::lower_bound(vertices.begin(), vertices.end(), i) - vertices.begin());
    };
    std::vector<glm::vec3> positions;
    for (const std::uint32_t v : vertices)
        positions.push_back(geometry.positions[v]);
    for (glm::uvec3& t : free)
        t = {local(t.x), local(t.y), local(t.z)};
    for (const glm::uvec3& t : simplified(positions, free, allowed))
        kept.emplace_back(vertices[t.x], vertices[t.y], vertices[t.z]);
    return kept;
}

}  // namespace

std::vector<glm::uvec3> simplified(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles,
                                   double allowed_m) {
    const float scale = meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(glm::vec3));
    if (!(scale > 0) || !(allowed_m > 0))
        return triangles;
    std::vector<glm::uvec3> fewer(triangles.size());
    const std::size_t indices =
        meshopt_simplify(&fewer[0].x, &triangles[0].x, triangles.size() * 3, &positions[0].x, positions.size(),
                         sizeof(glm::vec3), 0, float(allowed_m) / scale, meshopt_SimplifyLockBorder, nullptr);
    fewer.resize(indices / 3);
    return fewer;
}

std::vector<glm::uvec3> simplified(const StaticGeometry& geometry, const HeadBoxes& boxes, double error_rad) {
    StaticGeometry now{geometry.positions, geometry.strictness, geometry.triangles};
    for (const Pass& pass : passes) {
        std::vector<Placed> placed(now.triangles.size());
        tbb::parallel_for(std::size_t{0}, placed.size(),
                          [&](std::size_t i) { placed[i] = place(now, std::uint32_t(i), boxes, error_rad, pass); });
        tbb::parallel_sort(placed.begin(), placed.end());
        std::vector<std::span<const Placed>> clusters;
        for (std::size_t begin = 0, end = 0; begin < placed.size(); begin = end) {
            while (end < placed.size() && placed[end].key == placed[begin].key)
                ++end;
            clusters.emplace_back(&placed[begin], end - begin);
        }
        std::vector<std::vector<glm::uvec3>> results(clusters.size());
        tbb::parallel_for(std::size_t{0}, clusters.size(),
                          [&](std::size_t i) { results[i] = simplify_cluster(now, clusters[i]); });
        now.triangles.clear();
        for (const std::vector<glm::uvec3>& result : results)
            now.triangles.insert(now.triangles.end(), result.begin(), result.end());
    }
    return now.triangles;
}

std::vector<std::uint32_t> weld(std::span<const glm::vec3> positions) {
    std::vector<std::uint32_t> point(positions.size());
    if (!positions.empty())
        meshopt_generateVertexRemap(point.data(), nullptr, positions.size(), positions.data(), positions.size(),
                                    sizeof(glm::vec3));
    return point;
}

Mesh part_of(const Mesh& mesh, std::span<const glm::uvec3> triangles) {
    Mesh part;
    part.name = mesh.name;
    part.material = mesh.material;
    std::vector<std::uint32_t> new_index(mesh.positions.size(), no_index);
    part.triangles.reserve(triangles.size());
    for (const glm::uvec3& t : triangles) {
        glm::uvec3 renumbered;
        for (int corner = 0; corner < 3; ++corner) {
            std::uint32_t& index = new_index[t[corner]];
            if (index == no_index) {
                index = std::uint32_t(part.positions.size());
                part.positions.push_back(mesh.positions[t[corner]]);
                if (!mesh.uvs.empty())
                    part.uvs.push_back(mesh.uvs[t[corner]]);
            }
            renumbered[corner] = index;
        }
        part.triangles.push_back(renumbered);
    }
    return part;
}

}  // namespace equistream
