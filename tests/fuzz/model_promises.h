#pragma once
/// What holds of every model that load_model gives.
#include "target.h"

#include <scenes/library/model.h>

#include <algorithm>

namespace equistream::fuzz {

inline void check_promises(const Mesh& mesh, const SceneModel& model) {
    require(mesh.material < model.materials.size(), "a mesh's material is there");
    require(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size(), "one normal a position, or none");
    require(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size(), "one texture coordinate a position, or none");
    for (const glm::uvec3& corner : mesh.triangles)
        require(std::max({corner.x, corner.y, corner.z}) < mesh.positions.size(), "a triangle's corners are there");
}

inline void check_promises(const SceneModel& model) {
    require(model.triangle_count() > 0, "there is a triangle");
    for (const Mesh& mesh : model.meshes)
        check_promises(mesh, model);
    for (const Instance& instance : model.instances)
        require(instance.mesh < model.meshes.size() && instance.object < model.objects.size(),
                "what an instance places is there");
    for (const AlphaMask& mask : model.alpha_masks)
        require(mask.opaque.size() == static_cast<std::size_t>(mask.width) * static_cast<std::size_t>(mask.height),
                "a mask has its texels");
}

}  // namespace equistream::fuzz
