#pragma once
/// A ball before a square wall, as triangles and in closed form.
#include <tests/unit/client/analytic_scene.h>
#include <tests/unit/client/squares.h>

namespace equistream::test {

/// A ball made of triangles: its corners lie on it, its middle at `at`.
inline void add_ball(SceneModel& model, const glm::vec3& at, float radius, int steps) {
    Mesh mesh;
    for (int j = 0; j <= steps; ++j)
        for (int i = 0; i <= 2 * steps; ++i) {
            const double longitude = pi * i / steps, latitude = pi * j / steps;
            const glm::dvec3 unit(std::sin(latitude) * std::cos(longitude), std::cos(latitude),
                                  std::sin(latitude) * std::sin(longitude));
            mesh.positions.emplace_back(double(radius) * unit);
        }
    const auto row = std::uint32_t(2 * steps + 1);
    for (std::uint32_t j = 0; j < std::uint32_t(steps); ++j)
        for (std::uint32_t i = 0; i < std::uint32_t(2 * steps); ++i) {
            const std::uint32_t a = j * row + i;
            mesh.triangles.emplace_back(a, a + 1, a + row);
            mesh.triangles.emplace_back(a + 1, a + row + 1, a + row);
        }
    mesh.material = 0;
    glm::mat4 transform(1);
    transform[3] = glm::vec4(at, 1);
    model.instances.push_back({std::uint32_t(model.meshes.size()), std::uint32_t(model.objects.size()), transform});
    model.meshes.push_back(mesh);
    model.objects.push_back({"ball", -1});
}

inline SceneModel ball_and_square() {
    SceneModel model;
    model.materials.resize(2);
    add_ball(model, {0.3f, 0.2f, -2}, 0.5f, 60);
    add_square(model, "wall", 3, {0, 0, -4}, 0);
    return model;
}

inline double ball_and_square_m(const glm::dvec3& o, const glm::dvec3& d) {
    const double wall = to_plane(o, d, {0, 0, 1}, -4);
    const glm::dvec3 p = o + wall * d;
    return std::min(to_sphere(o, d, glm::vec3(0.3f, 0.2f, -2), 0.5),
                    std::max(std::abs(p.x), std::abs(p.y)) <= 3 ? wall : infinity);
}

}  // namespace equistream::test
