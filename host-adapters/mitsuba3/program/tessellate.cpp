#include "tessellate.h"

#include <equistream/conventions.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

namespace equistream::mitsuba_host {
namespace {

constexpr int fewest_segments = 16;
constexpr int max_segments = 1024;

/// Segments of a whole circle whose chords and arc are nowhere farther apart than twice the tolerance, in `directions`
/// of which a surface bends: a segment of angle a misses by r a^2 / 8 in each.
struct Segments {
    int count = fewest_segments;
    double outwards = 1;  ///< what brings the surface's error to either side of it
    bool coarser = false;

    Segments(double radius, double tolerance, int directions) {
        const double angle = std::sqrt(16 * tolerance / (radius * directions));
        const double wanted = std::ceil(2 * pi / std::max(angle, 1e-9));
        coarser = wanted > max_segments;
        count = static_cast<int>(std::clamp(wanted, double{fewest_segments}, double{max_segments}));
        count = (count + 1) / 2 * 2;
        const double step = 2 * pi / count;
        outwards = 1 + directions * step * step / 16;
    }
};

double max_scale(const glm::dmat4& m) {
    return std::max({glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])), glm::length(glm::dvec3(m[2]))});
}

/// A grid of columns x rows cells over [0, 1]^2.
Mesh grid(int columns, int rows, const std::function<glm::dvec3(double, double)>& at) {
    Mesh mesh;
    for (int y = 0; y <= rows; ++y)
        for (int x = 0; x <= columns; ++x) {
            const double u = static_cast<double>(x) / columns, v = static_cast<double>(y) / rows;
            mesh.positions.emplace_back(at(u, v));
            mesh.uvs.emplace_back(u, v);
        }
    const auto index = [columns](int x, int y) { return static_cast<std::uint32_t>(y * (columns + 1) + x); };
    for (int y = 0; y < rows; ++y)
        for (int x = 0; x < columns; ++x) {
            mesh.triangles.emplace_back(index(x, y), index(x, y + 1), index(x + 1, y + 1));
            mesh.triangles.emplace_back(index(x, y), index(x + 1, y + 1), index(x + 1, y));
        }
    return mesh;
}

glm::dvec3 moved(const glm::dmat4& m, const glm::dvec3& p) {
    return glm::dvec3(m * glm::dvec4(p, 1));
}

Tessellation sphere(const glm::dmat4& m, double tolerance) {
    const Segments s(max_scale(m), tolerance, 2);
    return {grid(s.count, s.count / 2,
                 [&](double u, double v) {
                     const double ring = s.outwards * std::sin(pi * v);
                     return moved(
                         m, {ring * std::cos(2 * pi * u), ring * std::sin(2 * pi * u), s.outwards * std::cos(pi * v)});
                 }),
            s.coarser};
}

Tessellation cylinder(const glm::dmat4& m, double tolerance) {
    const Segments s(std::max(glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1]))), tolerance, 1);
    return {grid(s.count, 1,
                 [&](double u, double v) {
                     return moved(m, {s.outwards * std::cos(2 * pi * u), s.outwards * std::sin(2 * pi * u), v});
                 }),
            s.coarser};
}

Tessellation disk(const glm::dmat4& m, double tolerance) {
    const Segments s(std::max(glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1]))), tolerance, 1);
    Mesh mesh;
    mesh.positions.emplace_back(moved(m, {0, 0, 0}));
    for (int i = 0; i < s.count; ++i) {
        const double angle = 2 * pi * i / s.count;
        mesh.positions.emplace_back(moved(m, {s.outwards * std::cos(angle), s.outwards * std::sin(angle), 0}));
        mesh.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % s.count);
    }
    return {std::move(mesh), s.coarser};
}

}  // namespace

bool is_analytic(const std::string& class_name) {
    return class_name == "Sphere" || class_name == "Disk" || class_name == "Rectangle" || class_name == "Cylinder";
}

Tessellation tessellate(const std::string& class_name, const glm::dmat4& to_world, double tolerance) {
    assert(is_analytic(class_name));
    if (class_name == "Sphere")
        return sphere(to_world, tolerance);
    if (class_name == "Cylinder")
        return cylinder(to_world, tolerance);
    if (class_name == "Disk")
        return disk(to_world, tolerance);
    return {grid(1, 1, [&](double u, double v) { return moved(to_world, {2 * u - 1, 2 * v - 1, 0}); }), false};
}

}  // namespace equistream::mitsuba_host
