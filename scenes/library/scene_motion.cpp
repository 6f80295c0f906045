#include <equistream_scene/scene.h>

#include <equistream/error.h>

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>
#include <optional>
#include <unordered_map>

namespace equistream {

namespace {

/// Scale of a transform along its own axes, a mirror image counted on the first; shear is lost.
glm::dvec3 scale_of(const glm::dmat4& m) {
    glm::dvec3 scale(glm::length(glm::dvec3(m[0])), glm::length(glm::dvec3(m[1])), glm::length(glm::dvec3(m[2])));
    if (glm::determinant(glm::dmat3(m)) < 0)
        scale.x = -scale.x;
    return scale;
}

/// For each moving entry the object it names.
std::unordered_map<std::uint32_t, std::size_t> moving_objects(const SceneModel& model, const SceneDescription& scene) {
    std::unordered_map<std::uint32_t, std::size_t> entry_of_object;
    for (std::size_t entry = 0; entry < scene.moving.size(); ++entry) {
        const std::string& name = scene.moving[entry].object;
        std::optional<std::uint32_t> found;
        for (std::uint32_t object = 0; object < model.objects.size(); ++object)
            if (model.objects[object].name == name) {
                if (found)
                    throw InputError(
                        expected_found(scene.file.string(), "one node named \"" + name + "\" in the model", "several"));
                found = object;
            }
        if (!found)
            throw InputError(expected_found(scene.file.string(), "a node named \"" + name + "\" in the model", "none"));
        if (!std::isnormal(glm::determinant(glm::mat3(model.objects[*found].world_from_object))))
            throw InputError(expected_found(scene.file.string(), "a node of some volume to move", "\"" + name + "\""));
        entry_of_object[*found] = entry;
    }
    return entry_of_object;
}

/// The nearest of an object and its parents that moves by itself; no_index if none does.
std::uint32_t mover_of(const SceneModel& model, std::uint32_t object,
                       const std::unordered_map<std::uint32_t, std::size_t>& moving) {
    for (int o = static_cast<int>(object); o >= 0; o = model.objects[static_cast<std::size_t>(o)].parent)
        if (moving.contains(static_cast<std::uint32_t>(o)))
            return static_cast<std::uint32_t>(o);
    return no_index;
}

}  // namespace

std::vector<std::uint32_t> find_moving_instances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::vector<std::uint32_t> instances;
    if (moving.empty())
        return instances;
    for (std::uint32_t i = 0; i < model.instances.size(); ++i)
        if (mover_of(model, model.instances[i].object, moving) != no_index)
            instances.push_back(i);
    return instances;
}

MovedInstances::MovedInstances(const SceneModel& model, const SceneDescription& scene) {
    const auto moving = moving_objects(model, scene);
    std::unordered_map<std::uint32_t, std::size_t> mover_of_object;
    for (const auto& [object, entry] : moving) {
        const glm::dmat4 rest(model.objects[object].world_from_object);
        mover_of_object[object] = movers_.size();
        movers_.push_back({scene.moving[entry].path, scale_of(rest), glm::inverse(rest)});
    }
    for (const Instance& instance : model.instances) {
        const std::uint32_t mover = moving.empty() ? no_index : mover_of(model, instance.object, moving);
        if (mover != no_index)
            moving_.push_back(
                {world_from_object_.size(), mover_of_object[mover], glm::dmat4(instance.world_from_object)});
        world_from_object_.push_back(instance.world_from_object);
    }
}

const std::vector<glm::mat4>& MovedInstances::at(double time_s) {
    for (Mover& mover : movers_) {
        const Pose pose = mover.path.at(time_s);
        mover.moved_from_rest = glm::translate(glm::dmat4(1), pose.position_m) * glm::mat4_cast(pose.orientation) *
                                glm::scale(glm::dmat4(1), mover.scale) * mover.object_from_rest;
    }
    for (const Moving& one : moving_)
        world_from_object_[one.instance] = glm::mat4(movers_[one.mover].moved_from_rest * one.rest);
    return world_from_object_;
}

std::vector<glm::mat4> instance_transforms(const SceneModel& model, const SceneDescription& scene, double time_s) {
    return MovedInstances(model, scene).at(time_s);
}

}  // namespace equistream
