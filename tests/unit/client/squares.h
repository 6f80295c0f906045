#pragma once
/// Squares to look at in tests of depth and colour cast from geometry.
#include <scenes/library/model.h>

#include <cstdint>
#include <string>

namespace equistream::test {

/// Adds a square that faces +Z, its middle at a place, with texture coordinates from its upper left corner.
inline void add_square(SceneModel& model, const std::string& name, float half, const glm::vec3& at,
                       std::uint32_t material) {
    Mesh mesh;
    mesh.name = name;
    mesh.positions = {{-half, -half, 0}, {half, -half, 0}, {half, half, 0}, {-half, half, 0}};
    mesh.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = material;
    glm::mat4 transform(1);
    transform[3] = glm::vec4(at, 1);
    model.instances.push_back({std::uint32_t(model.meshes.size()), std::uint32_t(model.objects.size()), transform});
    model.meshes.push_back(mesh);
    model.objects.push_back({name, -1});
}

}  // namespace equistream::test
