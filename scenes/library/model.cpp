#include <equistream_scene/model.h>

#include "gltf_document.h"
#include "obj_files.h"
#include "obj_model.h"

#include <equistream_scene/scene.h>

#include <glm/gtc/matrix_transform.hpp>

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

SceneModel load_model(const std::filesystem::path& file, const ModelOptions& options) {
    SceneModel model = is_obj(file) ? load_obj(file, options) : load_gltf(file, options);
    model.file = file;
    return model;
}

SceneModel load_model(const SceneDescription& scene, const ModelOptions& options) {
    SceneModel model = load_model(scene.model, options);
    if (scene.model_unit_m != 1) {
        const glm::mat4 metres = glm::scale(glm::mat4(1), glm::vec3(static_cast<float>(scene.model_unit_m)));
        for (Instance& instance : model.instances)
            instance.world_from_object = metres * instance.world_from_object;
        for (Object& object : model.objects)
            object.world_from_object = metres * object.world_from_object;
    }
    return model;
}

}  // namespace equistream
