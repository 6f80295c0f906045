#include "weld.h"

#include <meshoptimizer.h>

namespace equistream {

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
