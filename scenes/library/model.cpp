#include <equistream_scene/model.h>

namespace equistream {

std::uint32_t SceneModel::mask_of(const Mesh& mesh) const {
    return mesh.material < materials.size() && !mesh.uvs.empty() ? materials[mesh.material].alpha_mask : no_index;
}

std::uint64_t SceneModel::triangle_count() const {
    std::uint64_t count = 0;
    for (const Instance& instance : instances)
        count += meshes[instance.mesh].triangles.size();
    return count;
}

std::uint64_t SceneModel::unique_triangle_count() const {
    std::uint64_t count = 0;
    for (const Mesh& mesh : meshes)
        count += mesh.triangles.size();
    return count;
}

}  // namespace equistream
