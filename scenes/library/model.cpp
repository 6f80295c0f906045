#include "model.h"

#include "gltf_document.h"
#include "obj_files.h"
#include "obj_model.h"

#include "scene.h"

#include <equistream/error.h>
#include <equistream/formatted.h>
#include <equistream/pose_limits.h>

#include <glm/gtc/matrix_transform.hpp>

namespace equistream {

namespace {

struct Box {
    glm::dvec3 low{0}, high{0};

    glm::dvec3 corner(int i) const {
        return {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y, (i & 4) != 0 ? high.z : low.z};
    }
};

Box box_of(const Mesh& mesh) {
    if (mesh.positions.empty())
        return {};
    Box box{mesh.positions.front(), mesh.positions.front()};
    for (const glm::vec3& p : mesh.positions)
        box = {glm::min(box.low, glm::dvec3(p)), glm::max(box.high, glm::dvec3(p))};
    return box;
}

/// Rays are cast in floats, which overflow where coordinates are far beyond the limit, in the mesh or in the world.
void require_positions(const SceneModel& model) {
    const auto require = [&](const glm::dvec3& p, const std::string& what) {
        if (!is_position(p))
            throw InputError(expected_found(model.file.string() + ": " + what, "coordinates from -1e9 to 1e9",
                                            formatted("(%g, %g, %g)", p.x, p.y, p.z)));
    };
    std::vector<Box> boxes;
    for (const Mesh& mesh : model.meshes) {
        boxes.push_back(box_of(mesh));
        for (const glm::dvec3& end : {boxes.back().low, boxes.back().high})
            require(end, "mesh \"" + mesh.name + "\"");
    }
    for (const Instance& instance : model.instances)
        for (int i = 0; i < 8; ++i)
            require(glm::dmat4(instance.world_from_object) * glm::dvec4(boxes[instance.mesh].corner(i), 1),
                    "node \"" + model.objects[instance.object].name + "\", in metres");
}

SceneModel read_model(const std::filesystem::path& file, const ModelOptions& options) {
    SceneModel model = is_obj(file) ? load_obj(file, options) : load_gltf(file, options);
    model.file = file;
    return model;
}

}  // namespace

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
    SceneModel model = read_model(file, options);
    require_positions(model);
    return model;
}

SceneModel load_model(const SceneDescription& scene, const ModelOptions& options) {
    SceneModel model = read_model(scene.model, options);
    if (scene.model_unit_m != 1) {
        const glm::mat4 metres = glm::scale(glm::mat4(1), glm::vec3(static_cast<float>(scene.model_unit_m)));
        for (Instance& instance : model.instances)
            instance.world_from_object = metres * instance.world_from_object;
        for (Object& object : model.objects)
            object.world_from_object = metres * object.world_from_object;
    }
    require_positions(model);
    return model;
}

}  // namespace equistream
